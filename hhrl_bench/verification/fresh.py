"""Fresh worlds, drawn anew, in which an agent that was fitted to the public test worlds shows."""

from collections.abc import Iterator

import numpy as np

from hhrl_bench.evaluation.store import Store
from hhrl_bench.leaderboard.findings import Finding
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.progress import Update, silent
from hhrl_bench.tasks.seeds import RANGE_SIZE, SeedRange
from hhrl_bench.tasks.tasks import TEST
from hhrl_bench.verification.rerun import play
from hhrl_bench.verification.verify import checked_results
from hhrl_envs import Outcome

FRESH = SeedRange("fresh", TEST.start + TEST.size, 2**62)
"""Worlds that no training, validation or test has."""

UNLIKELY = 0.001
"""How small the chance of a difference has to be, divided by the number of results, to be a finding."""


def check_fresh(
    board: LeaderboardRecord, store: Store, episodes: int, seed: int, update: Update = silent
) -> Iterator[Finding]:
    """Return the results whose published success is unlike that in ``episodes`` fresh worlds a run, drawn by ``seed``.

    Fisher's exact test on the episodes of all runs of a result together, at UNLIKELY over the number of results.
    Results that are not playable are left out.
    """
    from scipy.stats import fisher_exact  # noqa: PLC0415

    worlds = FRESH.take(episodes, int(np.random.default_rng(seed).integers(FRESH.size - RANGE_SIZE)))
    for done, checked in enumerate(checked_results(board, store), start=1):
        result = checked.result
        if not checked.playable:
            continue
        hits = [int((play(checked, run, worlds).records.outcome == Outcome.SUCCESS).sum()) for run in result.runs]
        total, known = episodes * len(hits), checked.task_record.episodes * len(hits)
        before = round(sum(run.metrics.success for run in result.runs) / len(hits) * known)
        table = np.array([[before, known - before], [sum(hits), total - sum(hits)]])
        said = f"{before / known:.1%} is published, {sum(hits) / total:.1%} was found in {total:,} fresh episodes"
        update(done, len(board.results), f"{result.agent} on {result.task}: {said}")
        if (chance := float(fisher_exact(table).pvalue)) < UNLIKELY / len(board.results):
            yield Finding(f"{checked.place}.metrics.success", f"{said} (chance of that: {chance:.1g})")
