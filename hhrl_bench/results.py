"""Results: the runs of one agent on one task, and what they come to."""

from collections.abc import Sequence

import numpy as np

from hhrl_bench import traffic
from hhrl_bench.casting import load_opponent
from hhrl_bench.episodes import EpisodeRecords
from hhrl_bench.errors import AgentError
from hhrl_bench.evaluation import evaluate
from hhrl_bench.loading import LoadedAgent, load_agents
from hhrl_bench.metrics import METRICS, Metric, finite, means
from hhrl_bench.players import OPTIONS
from hhrl_bench.progress import Update, silent
from hhrl_bench.provenance import provenance
from hhrl_bench.records import (
    SCHEMA_VERSION,
    EvaluationRecord,
    MetricsRecord,
    OpponentRecord,
    OptionName,
    ResultRecord,
    RunMetricsRecord,
    RunRecord,
    TaskRecord,
    TimedResult,
    metric_record,
)
from hhrl_bench.statistics import CONFIDENCE, Estimate, bootstrap_mean, wilson
from hhrl_bench.tasks import Task
from hhrl_bench.threads import one_torch_thread
from hhrl_envs import get_scenario

BOOTSTRAP_SEED = 20200725


def evaluate_agent(
    source: str, task: Task, episodes: int, option: OptionName | None = None, update: Update = silent
) -> ResultRecord:
    """Return the result of every training seed of agent ``source`` on the first ``episodes`` test episodes.

    ``update`` hears how many runs are done. Errors are those of :func:`hhrl_bench.evaluation.evaluate` and
    :func:`hhrl_bench.loading.load_agents`.
    """
    agents = load_agents(source, get_scenario(task.scenario))
    held = None if option is None else OPTIONS[option]
    played: list[EpisodeRecords] = []
    with one_torch_thread():
        for loaded in agents:
            try:
                played.append(evaluate(loaded.agent, task, episodes, held))
            except AgentError as error:
                raise AgentError(f"{source}: {error}") from error
            update(len(played), len(agents), f"success {means(played[-1])['success']:.1%}")
    rng = np.random.default_rng(BOOTSTRAP_SEED)
    return ResultRecord(
        agent=source,
        kind=agents[0].kind,
        task=task.id,
        option=option,
        runs=tuple(_run_record(loaded, records) for loaded, records in zip(agents, played, strict=True)),
        metrics=summarise(played, rng),
        traffic=traffic.summarise(played, rng),
    )


def evaluation_record(task: TaskRecord, timed: Sequence[TimedResult], command: str) -> EvaluationRecord:
    """Return the record of agents on one task, which ``command`` made."""
    return EvaluationRecord(
        schema_version=SCHEMA_VERSION,
        confidence=CONFIDENCE,
        bootstrap_seed=BOOTSTRAP_SEED,
        task=task,
        results=tuple(one.result for one in timed),
        provenance=provenance(command, wall_seconds(timed)),
    )


def wall_seconds(timed: Sequence[TimedResult]) -> dict[str, float]:
    """Return what each result took, by task and agent."""
    return {f"{one.result.task}/{one.result.agent}": one.seconds for one in timed}


def task_record(task: Task, episodes: int) -> TaskRecord:
    """Return the record of a task whose first ``episodes`` test episodes are played."""
    scenario, seeds = get_scenario(task.scenario), task.test.take(episodes)
    return TaskRecord(
        id=task.id,
        scenario=scenario.id,
        spec_hash=scenario.spec_hash,
        interface_hash=scenario.interface_hash,
        env_steps=task.env_steps,
        test_start=int(seeds[0]),
        episodes=len(seeds),
        shared=task.shared,
        opponent=_opponent_record(task),
    )


def _opponent_record(task: Task) -> OpponentRecord | None:
    loaded = load_opponent(task)
    if task.opponent is None or loaded is None:
        return None
    return OpponentRecord(agent=task.opponent, checkpoint_sha256=loaded.sha256)


def summarise(played: Sequence[EpisodeRecords], rng: np.random.Generator) -> MetricsRecord:
    """Return every metric with its interval: over training seeds if there are several, else over episodes."""
    return MetricsRecord(**{metric.key: metric_record(_estimate(metric, played, rng)) for metric in METRICS})


def _estimate(metric: Metric, played: Sequence[EpisodeRecords], rng: np.random.Generator) -> Estimate:
    values = [metric.values(records) for records in played]
    if len(values) > 1:
        return bootstrap_mean(np.array([np.mean(run) for run in values]), rng, "bootstrap-seeds")
    if metric.is_rate:
        return wilson(int(values[0].sum()), len(values[0]))
    return bootstrap_mean(values[0], rng, "bootstrap-episodes")


def _run_record(loaded: LoadedAgent, records: EpisodeRecords) -> RunRecord:
    return RunRecord(
        checkpoint_sha256=loaded.sha256,
        training=loaded.training,
        episodes_sha256=records.digest(),
        metrics=RunMetricsRecord.model_validate(finite(means(records))),
        traffic=traffic.counts(records),
    )
