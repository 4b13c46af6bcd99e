"""What an entry says that follows from its results, its learning curves and its files."""

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Any

import numpy as np

from hhrl_bench import checkpoint_metadata
from hhrl_bench.evaluation.evidence import read_evidence
from hhrl_bench.evaluation.records import ResultRecord, RunRecord
from hhrl_bench.evaluation.store import Store, read
from hhrl_bench.leaderboard.comparisons import PairwiseRecord, Runs, compare
from hhrl_bench.leaderboard.efficiency import efficiency
from hhrl_bench.leaderboard.record import method_records
from hhrl_bench.statistics.intervals import FloatArray, generator
from hhrl_bench.training.records import TrainingOutcomesRecord
from hhrl_envs import Outcome


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
    metadata = [checkpoint_metadata.read(read(store.checkpoint(sha256))) for sha256 in hashes]
    return {
        "methods": method_records(metadata),
        "comparisons": tuple(_comparisons(results, store)),
        "trainings_sha256": tuple(training.digest() for training in trainings),
        "efficiency": tuple(efficiency(one, generator(f"{one.method} on {one.task}")) for one in trainings),
    }


def _comparisons(results: Sequence[ResultRecord], store: Store) -> Iterator[PairwiseRecord]:
    """Yield the comparison of the success of every two results on a task, in their order."""
    runs = [Runs(result.agent, [_success(run, store) for run in result.runs]) for result in results]
    for (result, a), (other, b) in combinations(zip(results, runs, strict=True), 2):
        if result.task == other.task:
            yield compare(a, b, result.task, "success", generator(f"{a.agent} {b.agent} {result.task}"))


def _success(run: RunRecord, store: Store) -> FloatArray:
    """Return 1 for every episode of a run that succeeded, else 0, float64 [N]."""
    outcome = read_evidence(run, store).outcome
    return np.asarray(outcome == Outcome.SUCCESS, np.float64)
