"""What an entry says that follows from its results, its learning curves and its files."""

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Any

from hhrl_bench.evaluation.evidence import read_evidence
from hhrl_bench.evaluation.metrics import Metric, compared
from hhrl_bench.evaluation.records import ResultRecord
from hhrl_bench.evaluation.store import Store
from hhrl_bench.leaderboard.comparisons import PairwiseRecord, Runs, compare
from hhrl_bench.leaderboard.efficiency import efficiency
from hhrl_bench.leaderboard.record import method_records
from hhrl_bench.statistics.intervals import generator
from hhrl_bench.training.learning_curves import TrainingOutcomesRecord
from hhrl_envs.arrays import Floats


def derived(
    results: Sequence[ResultRecord], trainings: Sequence[TrainingOutcomesRecord], store: Store, *, checkpoints: bool
) -> dict[str, Any]:
    """Return the fields of :class:`hhrl_bench.leaderboard.record.LeaderboardRecord` that follow from the others.

    checkpoints: whether the store has them; the methods are known from them.

    Raises:
        RecordError: if a file of the results is missing or damaged.
    """
    runs = [run for result in results for run in result.runs]
    hashes = dict.fromkeys(run.checkpoint_sha256 for run in runs if run.checkpoint_sha256 and checkpoints)
    metadata = [store.checkpoint_metadata(sha256) for sha256 in hashes]
    return {
        "methods": method_records(metadata),
        "comparisons": tuple(_comparisons(results, store)),
        "trainings_sha256": tuple(training.digest() for training in trainings),
        "efficiency": tuple(efficiency(one, generator(f"{one.method} on {one.task}")) for one in trainings),
    }


def _comparisons(results: Sequence[ResultRecord], store: Store) -> Iterator[PairwiseRecord]:
    """Yield the comparison of every two results on a task, in their order, by every metric that is compared."""
    metrics = [metric for metric in compared() if all(metric.key in result.metrics for result in results)]
    runs = [_runs(result, metrics, store) for result in results]
    for (result, a), (other, b) in combinations(zip(results, runs, strict=True), 2):
        if result.task == other.task:
            for metric in metrics:
                draws = generator(f"{result.agent} {other.agent} {result.task}{_suffix(metric)}")
                yield compare(a[metric.key], b[metric.key], result.task, metric.key, draws)


def _runs(result: ResultRecord, metrics: Sequence[Metric], store: Store) -> dict[str, Runs]:
    """Return the values of every metric in the episodes of a result's runs."""
    values: dict[str, list[Floats]] = {metric.key: [] for metric in metrics}
    for run in result.runs:
        evidence = read_evidence(run, store)
        for metric in metrics:
            values[metric.key].append(metric.values(evidence))
    return {key: Runs(result.agent, of_runs) for key, of_runs in values.items()}


def _suffix(metric: Metric) -> str:
    """Return what tells the draws of a metric from those of others; success has none, as it was there alone."""
    return "" if metric.key == "success" else f" {metric.key}"
