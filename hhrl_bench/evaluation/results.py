"""Results: the runs of one agent on one task, and what they come to."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import NamedTuple, get_args

import numpy as np

from hhrl_bench.errors import AgentError
from hhrl_bench.evaluation.episodes import EpisodeRecords, TrafficRecords
from hhrl_bench.evaluation.evidence import pack
from hhrl_bench.evaluation.guarded_agent import OPTIONS
from hhrl_bench.evaluation.loading import LoadedAgent, load_agents
from hhrl_bench.evaluation.metrics import METRICS, Metric, known_metrics, means
from hhrl_bench.evaluation.paired_evaluation import ScoredEpisodes, load_opponent, play_task
from hhrl_bench.evaluation.records import (
    EvaluationRecord,
    Kind,
    MetricRecord,
    MetricsRecord,
    OpponentRecord,
    ResultRecord,
    RunMetricsRecord,
    RunRecord,
    RunTrafficRecord,
    TaskRecord,
    TimedResult,
    TrafficRecord,
    TrainingRecord,
    metric_record,
)
from hhrl_bench.evaluation.store import Store
from hhrl_bench.provenance import provenance
from hhrl_bench.schema import SCHEMA_VERSION, OptionName, OutcomeName, finite
from hhrl_bench.statistics.intervals import (
    BOOTSTRAP_SEED,
    CONFIDENCE,
    Estimate,
    IntervalKind,
    bootstrap_mean,
    generator,
    wilson,
)
from hhrl_bench.tasks.tasks import Task
from hhrl_envs import Outcome, get_scenario
from hhrl_envs.arrays import Floats
from hhrl_envs.simulation.survey import trajectory_digest

Update = Callable[[int, int, str], None]
"""What a loop calls to say how much is done, of how much, and a word about it."""


def silent(*_: object) -> None:
    """Do nothing: an ``Update`` that shows nothing."""


def evaluate_agent(
    source: str,
    task: Task,
    episodes: int,
    option: OptionName | None = None,
    update: Update = silent,
    store: Store | None = None,
    played_by: "Callable[[PlayedRun], object] | None" = None,
) -> ResultRecord:
    """Return the result of every training seed of agent ``source`` on the first ``episodes`` test episodes.

    ``update`` hears how many episodes of all runs have ended; ``store`` gets the runs' evidence and checkpoints,
    ``played_by`` each run. Errors are those of :func:`hhrl_bench.evaluate` and
    :func:`hhrl_bench.evaluation.loading.load_agents`.
    """
    agents = load_agents(source, get_scenario(task.scenario))
    played: list[PlayedRun] = []
    for loaded in agents:
        before, total = len(played) * episodes, len(agents) * episodes
        with loaded:
            ended = partial(_ended, update, before, total)
            played.append(play_run(source, loaded, task, episodes, option, store, ended))
        if played_by is not None:
            played_by(played[-1])
        update(before + episodes, total, f"success {played[-1].record.metrics.success:.1%}")
    return result_of(source, agents[0].kind, task, option, played)


class PlayedRun(NamedTuple):
    """One policy's test episodes, their record, and its training seed; None without one."""

    record: RunRecord
    scored: ScoredEpisodes
    seed: int | None


def play_run(
    name: str,
    loaded: LoadedAgent,
    task: Task,
    episodes: int,
    option: OptionName | None = None,
    store: Store | None = None,
    ended: Callable[[int], object] | None = None,
) -> PlayedRun:
    """Return the first ``episodes`` test episodes of one policy of the agent ``name``; see ``evaluate_agent``.

    ``ended`` hears how many of them have ended.
    """
    seeds, held = task.test.take(episodes), None if option is None else OPTIONS[option]
    try:
        played = play_task(loaded.agent, task, seeds, held, ended)
    except AgentError as error:
        raise type(error)(f"{name}: {error}") from error
    evidence = None if store is None else _keep(store, loaded, played)
    return PlayedRun(run_record(loaded.sha256, loaded.training, played.records, evidence), played, loaded.seed)


def result_of(
    agent: str, kind: Kind, task: Task, option: OptionName | None, played: Sequence[PlayedRun]
) -> ResultRecord:
    """Return the result of runs that were just played."""
    return result_record(
        agent, kind, task, option, [run.record for run in played], [run.scored.records for run in played]
    )


def _ended(update: Update, before: int, total: int, count: int) -> None:
    update(before + count, total, "")


def result_record(
    agent: str,
    kind: Kind,
    task: Task,
    option: OptionName | None,
    runs: Sequence[RunRecord],
    records: Sequence[EpisodeRecords],
) -> ResultRecord:
    """Return the result of runs whose episodes have these records."""
    return ResultRecord(
        agent=agent,
        kind=kind,
        task=task.id,
        option=option,
        runs=tuple(runs),
        metrics=summarise([run.metrics for run in runs], records[0]),
        traffic=summarise_traffic(records),
    )


def run_record(
    checkpoint: str | None,
    training: TrainingRecord | None,
    records: EpisodeRecords,
    evidence: str | None,
    metrics: Sequence[Metric] | None = None,
) -> RunRecord:
    """Return the record of one policy; by default with all metrics that the records know.

    ``checkpoint`` and ``evidence`` are the sha256 that they are kept under.
    """
    chosen = known_metrics(records) if metrics is None else metrics
    return RunRecord(
        checkpoint_sha256=checkpoint,
        training=training,
        evidence_sha256=evidence,
        episodes_sha256=records.only(metric.key for metric in chosen).digest(),
        metrics=RunMetricsRecord.model_validate(finite(means(records, chosen))),
        traffic=count_traffic(records),
    )


def summarise(runs: Sequence[RunMetricsRecord], records: EpisodeRecords) -> MetricsRecord:
    """Return every metric that all runs have, with its interval.

    It is over the means of several runs, over the episodes of a single one, which are ``records``.
    """
    metrics = [metric for key, metric in METRICS.items() if all(key in run for run in runs)]
    if len(runs) == 1:
        found = {metric.key: over_episodes(metric, metric.values(records)) for metric in metrics}
    else:
        found = {metric.key: over_runs(metric, [run.get(metric.key) for run in runs]) for metric in metrics}
    return MetricsRecord.model_validate(found)


def over_runs(metric: Metric, means: Sequence[float | None]) -> MetricRecord:
    """Return a metric of several runs from their means."""
    return metric_record(_bootstrap(metric, np.array(means, np.float64), "bootstrap-seeds"))


def over_episodes(metric: Metric, values: Floats) -> MetricRecord:
    """Return a metric of a single run from its values [episodes]."""
    if metric.is_rate:
        return metric_record(wilson(int(values.sum()), len(values)))
    return metric_record(_bootstrap(metric, values, "bootstrap-episodes"))


def _bootstrap(metric: Metric, values: Floats, kind: IntervalKind) -> Estimate:
    """Return the estimate of the values that are known; where none is, of nothing."""
    known = values[~np.isnan(values)]
    return bootstrap_mean(known if known.size else values, generator(metric.key), kind)


OUTCOMES: Mapping[OutcomeName, Outcome] = {name: Outcome[name.upper()] for name in get_args(OutcomeName)}


def count_traffic(records: EpisodeRecords) -> RunTrafficRecord | None:
    """Return the counts over the episodes of one run; None where the ego is the only agent of the world."""
    if not isinstance(records, TrafficRecords):
        return None
    return RunTrafficRecord(
        feasible=int(records.feasible.sum()),
        success_feasible=_successes(records),
        vehicles=tuple(
            {name: int((own == outcome).sum()) for name, outcome in OUTCOMES.items() if (own == outcome).any()}
            for own in records.outcomes.T
        ),
    )


def summarise_traffic(runs: Sequence[EpisodeRecords]) -> TrafficRecord | None:
    """Return the shares with their intervals, over runs if there are several, else over episodes; None as above."""
    known = [records for records in runs if isinstance(records, TrafficRecords)]
    if not known:
        return None
    feasible = [int(records.feasible.sum()) for records in known]
    lengths, successes = [len(records) for records in known], [_successes(records) for records in known]
    return TrafficRecord(
        feasible=metric_record(_share(feasible, lengths, "feasible")),
        success_feasible=metric_record(_share(successes, feasible, "success_feasible")),
    )


def _successes(records: TrafficRecords) -> int:
    return int(((records.outcome == Outcome.SUCCESS) & records.feasible).sum())


def _share(hits: Sequence[int], of: Sequence[int], key: str) -> Estimate:
    """Return the share of hits; not a number where there is nothing to count."""
    if len(of) == 1 and of[0] > 0:
        return wilson(hits[0], of[0])
    shares = np.array([hit / total if total else np.nan for hit, total in zip(hits, of, strict=True)])
    return bootstrap_mean(shares, generator(key), "bootstrap-seeds")


def _keep(store: Store, loaded: LoadedAgent, played: ScoredEpisodes) -> str:
    if loaded.path:
        store.add_checkpoint(loaded.path.read_bytes())
    return store.add_evidence(pack(played))


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
        golden_digest=trajectory_digest(scenario),
        env_steps=task.env_steps,
        train_start=task.train.start,
        validation_start=task.validation.start,
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
