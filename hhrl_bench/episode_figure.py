"""The figure of an agent's typical episode: distances, speeds, option, attention and rewards over time.

Needs the ``report`` extra.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hhrl_bench.analysis_episode import attention_over_episode
from hhrl_bench.analysis_episode_figure import draw_episode
from hhrl_bench.figures import save, style
from hhrl_bench.loading import LoadedAgent, load_agents
from hhrl_bench.tasks import Task, get_task
from hhrl_bench.threads import one_torch_thread
from hhrl_envs import Outcome, get_scenario


def typical_episode(outcome: NDArray[np.int8], steps: NDArray[np.int32]) -> int:
    """Return the number of the success whose length is the median of all successes; of all episodes if none succeeds.

    Args:
        outcome: how test episode 0, 1, ... ended (:class:`hhrl_envs.Outcome`), [N].
        steps: how long it was, [N].
    """
    successes = np.flatnonzero(outcome == Outcome.SUCCESS)
    places = successes if len(successes) else np.arange(len(outcome))
    by_length = places[np.argsort(steps[places], kind="stable")]
    return int(by_length[(len(places) - 1) // 2])


def save_episode(source: str | Path, task: str | Task, episode: int, folder: Path) -> list[Path]:
    """Return the files written into the folder, SVG and PNG: test episode ``episode`` of an agent on a task.

    Args:
        source: a registered name, a checkpoint file, a run directory, or ``module:factory``; of several training
            seeds, the lowest is shown.
        task: a task or its id.
        episode: which test episode.
        folder: where the files go.

    Raises:
        InputError: in one line, for anything that cannot be loaded, played or written.
    """
    task = get_task(task)
    scenario = get_scenario(task.scenario)
    loaded = load_agents(source, scenario)[0]
    with one_torch_thread():
        trace = attention_over_episode(loaded.agent, task, episode)
    name, seed = _name(source, loaded)
    with style(mathematics=True):
        figure = draw_episode(f"{name}{seed} on {task.id}", scenario, trace)
        return save(figure, folder, f"episode-{name.replace(':', '-')}-{task.id}")


def _name(source: str | Path, loaded: LoadedAgent) -> tuple[str, str]:
    """Return what the agent is called, and which training seed it is of, if any."""
    if loaded.training is None:
        return str(source), ""
    return loaded.training.method, f", training seed {loaded.training.seed},"
