"""Analysis of an agent: attention over an episode and the (d_f, d_d) plane, option usage, per-level rewards."""

from pathlib import Path

import numpy as np

from hhrl_agents import Agent
from hhrl_agents.files import require_writable, write_atomically
from hhrl_bench.analysis_attention import attend, attentive
from hhrl_bench.analysis_episode import attention_over_episode
from hhrl_bench.analysis_levels import level_rewards
from hhrl_bench.analysis_plane import Speeds, attention_over_plane, plane_states
from hhrl_bench.analysis_records import AnalysisRecord, Weights
from hhrl_bench.analysis_steps import Steps, record_steps
from hhrl_bench.analysis_usage import option_usage
from hhrl_bench.loading import load_agents
from hhrl_bench.players import OPTIONS
from hhrl_bench.records import SCHEMA_VERSION, OptionName
from hhrl_bench.results import task_record
from hhrl_bench.tasks import Task, get_task
from hhrl_bench.threads import one_torch_thread
from hhrl_envs import get_scenario
from hhrl_envs.extras import require
from hhrl_envs.observation import SYMBOLS

__all__ = [
    "Speeds",
    "analyse",
    "attention_over_episode",
    "attention_over_plane",
    "level_rewards",
    "mean_attention",
    "option_usage",
    "plane_states",
    "record_steps",
    "require_folder",
    "write",
]

FILE = "analysis.json"


def analyse(source: str, task: str | Task, episodes: int, episode: int = 0) -> AnalysisRecord:
    """Return the analysis of the agent that ``source`` names; of several training seeds, of the lowest.

    Args:
        source: a registered name, a checkpoint file, a run directory, or ``module:factory``.
        task: a task or its id.
        episodes: how many test episodes option usage and rewards are counted over.
        episode: the test episode that is shown step by step.

    Raises:
        InputError: in one line, for anything that cannot be loaded or played.
    """
    task = get_task(task)
    scenario = get_scenario(task.scenario)
    loaded = load_agents(source, scenario)[0]
    with one_torch_thread():
        trace = attention_over_episode(loaded.agent, task, episode)
        steps = record_steps(loaded.agent, task, episodes)
        return AnalysisRecord(
            schema_version=SCHEMA_VERSION,
            agent=source,
            kind=loaded.kind,
            checkpoint_sha256=loaded.sha256,
            training=loaded.training,
            task=task_record(task, episodes),
            levels=tuple(map(float, scenario.vehicle.levels)),
            episode=trace,
            plane=attention_over_plane(loaded.agent, scenario),
            option_usage=option_usage(steps, scenario),
            level_rewards=level_rewards(steps),
            attention=mean_attention(loaded.agent, steps),
        )


def mean_attention(agent: Agent, steps: Steps) -> dict[OptionName, Weights] | None:
    """Return the mean weights I(s, o) over the agent's steps, by selected option; None without options or attention."""
    able = attentive(agent)
    if able is None or not steps.hierarchical:
        return None
    weights = attend(able, steps.observations, steps.option).astype(np.float64)
    means = {name: weights[steps.option == o].mean(axis=0) for name, o in OPTIONS.items() if (steps.option == o).any()}
    return {name: dict(zip(SYMBOLS, mean.tolist(), strict=True)) for name, mean in means.items()}


def require_folder(folder: Path) -> None:
    """Return nothing; raise an ``InputError`` if an analysis could not be drawn or not be written into the folder."""
    require("matplotlib", extra="report")
    require_writable(folder / FILE)


def write(record: AnalysisRecord, folder: Path) -> list[Path]:
    """Return the files written into the folder: the record as JSON, and its figures.

    Equal analyses give equal files, byte for byte.
    """
    from hhrl_bench.analysis_figures import save_figures  # noqa: PLC0415

    path = folder / FILE
    write_atomically(path, record.model_dump_json() + "\n")
    return [path, *save_figures(record, folder)]
