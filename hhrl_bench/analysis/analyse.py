"""Analysis of an agent: attention over an episode and the (d_f, d_d) plane, option usage, per-level rewards."""

from hhrl_bench.analysis.attention import attention_over_episode, attention_over_plane, mean_attention
from hhrl_bench.analysis.levels import level_rewards, option_usage
from hhrl_bench.analysis.records import AnalysisRecord
from hhrl_bench.analysis.steps import record_steps
from hhrl_bench.evaluation.loading import load_agents
from hhrl_bench.evaluation.results import Update, silent, task_record
from hhrl_bench.schema import SCHEMA_VERSION
from hhrl_bench.tasks.tasks import AnyTask, get_task
from hhrl_envs import get_scenario


def analyse(source: str, task: AnyTask, episodes: int, episode: int = 0, update: Update = silent) -> AnalysisRecord:
    """Return the analysis of the agent that ``source`` names; of several training seeds, of the lowest.

    Args:
        source: a registered name, a checkpoint file, a run directory, or ``module:factory``.
        task: what names a task; see :func:`hhrl_bench.tasks.tasks.get_task`.
        episodes: how many test episodes option usage and rewards are counted over.
        episode: the test episode that is shown step by step.
        update: hears how many of the episodes are counted.

    Raises:
        InputError: in one line, for anything that cannot be loaded or run.
    """
    task = get_task(task)
    scenario = get_scenario(task.scenario)
    with load_agents(source, scenario)[0] as loaded:
        trace = attention_over_episode(loaded.agent, task, episode)
        steps = record_steps(loaded.agent, task, episodes, update)
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
