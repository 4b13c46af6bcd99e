"""Agents of an entry run again: in the same worlds, where they decide the same, and in fresh ones.

In worlds that are drawn anew, an agent that was fitted to the public test worlds shows.
"""

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from hhrl_bench.evaluation.decisions import Trace
from hhrl_bench.evaluation.guarded_agent import OPTIONS
from hhrl_bench.evaluation.loading import load_agents
from hhrl_bench.evaluation.paired_evaluation import ScoredEpisodes, play_task
from hhrl_bench.evaluation.records import RunRecord
from hhrl_bench.evaluation.results import Update, silent
from hhrl_bench.evaluation.store import Store
from hhrl_bench.execution.pools import Each
from hhrl_bench.leaderboard.findings import Finding
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.tasks.seeds import RANGE_SIZE, SeedRange
from hhrl_bench.tasks.tasks import TEST
from hhrl_bench.verification.checked_result import CheckedResult, checked_results
from hhrl_envs import Outcome, get_scenario
from hhrl_envs.arrays import Codes, Flags, Keys
from hhrl_envs.errors import InputError


def rerun(checked: CheckedResult) -> Iterator[Finding]:
    """Return the runs that decide otherwise in some episode, run again, of a result that is playable."""
    if not checked.playable:
        return
    for (place, run), known in zip(checked.runs(), checked.known, strict=True):
        if known is not None:
            yield from decides_otherwise(place, checked, run, checked.read(run).trace)


def decides_otherwise(place: str, checked: CheckedResult, run: RunRecord, trace: Trace) -> Iterator[Finding]:
    """Return whether a run's agent, run again, decides otherwise than in its trace, and in how many episodes."""
    try:
        same = same_episodes(trace, run_again(checked, run, checked.seeds).trace)
    except InputError as error:
        yield Finding(place, f"cannot be run again: {error}")
        return
    if not same.all():
        others = f"in {(~same).sum():,} of {len(same):,} episodes, first in episode {same.argmin()}"
        yield Finding(place, f"run again, it decides otherwise {others}")


def same_episodes(trace: Trace, other: Trace) -> Flags:
    """Return for each of N episodes whether two traces hold the same decisions, bool [N]."""
    pairs = zip(_split(trace), _split(other), strict=True)
    return np.array([all(map(np.array_equal, one, two)) for one, two in pairs])


def _split(trace: Trace) -> Iterator[tuple[Codes, Codes]]:
    """Return the options and the actions of every episode."""
    ends = np.cumsum(trace.steps)[:-1]
    return zip(np.split(trace.options, ends), np.split(trace.actions, ends), strict=True)


def run_again(checked: CheckedResult, run: RunRecord, seeds: Keys) -> ScoredEpisodes:
    """Return what a run's agent does in these worlds."""
    result, task = checked.result, checked.task
    agent: str | Path = checked.store.checkpoint(run.checkpoint_sha256) if run.checkpoint_sha256 else result.agent
    (loaded,) = load_agents(agent, get_scenario(task.scenario))
    return play_task(loaded.agent, task, seeds, OPTIONS[result.option] if result.option else None)


FRESH = SeedRange("fresh", TEST.start + TEST.size, 2**62)
"""Worlds that no training, validation or test has."""

UNLIKELY = 0.001
"""How small the chance of a difference has to be, divided by the number of results, to be a finding."""


def check_fresh(
    board: LeaderboardRecord, store: Store, episodes: int, seed: int, update: Update = silent, each: Each = map
) -> Iterator[Finding]:
    """Return the results whose published success is unlike that in ``episodes`` fresh worlds a run, drawn by ``seed``.

    Fisher's exact test on the episodes of all runs of a result together, at UNLIKELY over the number of results.
    Results that are not playable are left out. ``each`` plays the results, as ``map`` does.
    """
    from scipy.stats import fisher_exact  # noqa: PLC0415

    worlds = FRESH.take(episodes, int(np.random.default_rng(seed).integers(FRESH.size - RANGE_SIZE)))
    playable = [one for one in checked_results(board, store) if one.playable]
    for done, (checked, hits) in enumerate(zip(playable, each(partial(successes, worlds), playable), strict=True)):
        result = checked.result
        total, known = episodes * len(hits), checked.task_record.episodes * len(hits)
        before = round(sum(run.metrics.success for run in result.runs) / len(hits) * known)
        table = np.array([[before, known - before], [sum(hits), total - sum(hits)]])
        said = f"{before / known:.1%} is published, {sum(hits) / total:.1%} was found in {total:,} fresh episodes"
        update(done + 1, len(playable), f"{result.agent} on {result.task}: {said}")
        if (chance := float(fisher_exact(table).pvalue)) < UNLIKELY / len(board.results):
            yield Finding(f"{checked.place}.metrics.success", f"{said} (chance of that: {chance:.1g})")


def successes(worlds: Keys, checked: CheckedResult) -> list[int]:
    """Return in how many of these worlds every run of a result succeeds."""
    played = (run_again(checked, run, worlds).records for run in checked.result.runs)
    return [int((records.outcome == Outcome.SUCCESS).sum()) for records in played]
