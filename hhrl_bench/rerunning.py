"""Agents of an entry run again: in the same worlds, and in fresh ones that nobody can have fitted an agent to."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hhrl_bench.checked_result import CheckedResult
from hhrl_bench.differences import Finding
from hhrl_bench.evaluation import Played, play_task
from hhrl_bench.loading import load_agents
from hhrl_bench.players import OPTIONS
from hhrl_bench.records import RunRecord
from hhrl_bench.seeds import RANGE_SIZE, SeedRange, UInt64Array
from hhrl_bench.tasks import TEST
from hhrl_bench.threads import one_torch_thread
from hhrl_bench.traces import Trace
from hhrl_envs import Outcome, get_scenario

SAME = 0.9
"""The share of episodes in which an agent has to decide the same again; another machine may round differently."""

UNLIKELY = 0.001
"""A difference to fresh worlds that has a smaller chance than that, divided by the number of results, is a finding."""

FRESH = SeedRange("fresh", TEST.start + TEST.size, 2**62)
"""Worlds that no training, validation or test has."""


def rerun(checked: CheckedResult) -> Iterator[Finding]:
    """Return the runs that do not decide the same again in ``SAME`` of the episodes; the user's own code is not run."""
    if checked.result.kind == "factory":
        return
    for (place, run), evidence in zip(checked.runs(), checked.evidence, strict=True):
        if evidence is not None:
            same = np.mean(same_episodes(evidence.trace, _play(checked, run, checked.seeds).trace))
            if same < SAME:
                yield Finding(place, f"run again, it decides the same in {same:.1%} of the episodes")


def same_episodes(trace: Trace, other: Trace) -> NDArray[np.bool_]:
    """Return for each of N episodes whether two traces hold the same decisions, bool [N]."""
    pairs = zip(_split(trace), _split(other), strict=True)
    return np.array([all(map(np.array_equal, one, two)) for one, two in pairs])


def _split(trace: Trace) -> Iterator[tuple[NDArray[np.int8], NDArray[np.int8]]]:
    """Return the options and the actions of every episode."""
    ends = np.cumsum(trace.steps)[:-1]
    return zip(np.split(trace.options, ends), np.split(trace.actions, ends), strict=True)


def check_fresh(checked: CheckedResult, episodes: int, seed: int, results: int) -> Iterator[Finding]:
    """Return a finding if success in ``episodes`` fresh worlds a run, drawn by ``seed``, is unlike the published one.

    Fisher's exact test on the episodes of all runs together, at UNLIKELY over the number of ``results`` tested.
    """
    from scipy.stats import fisher_exact  # noqa: PLC0415

    if checked.result.kind == "factory":
        return
    offset = int(np.random.default_rng(seed).integers(FRESH.size - RANGE_SIZE))
    worlds = FRESH.take(episodes, offset)
    fresh = [_play(checked, run, worlds).records.outcome == Outcome.SUCCESS for _, run in checked.runs()]
    total, hits = episodes * len(fresh), int(np.sum(fresh))
    published = [one.outcome == Outcome.SUCCESS for one in checked.evidence if one]
    known, before = sum(map(len, published)), int(sum(map(np.sum, published)))
    chance = fisher_exact(np.array([[before, known - before], [hits, total - hits]])).pvalue
    if chance < UNLIKELY / results:
        said = f"{before / known:.1%} is published, {hits / total:.1%} was found in {total:,} fresh episodes"
        yield Finding(f"{checked.place}.metrics.success", f"{said} (chance of that: {chance:.1g})")


def _play(checked: CheckedResult, run: RunRecord, seeds: UInt64Array) -> Played:
    """Return what a run's agent does in these worlds."""
    result, task = checked.result, checked.task
    agent: str | Path = checked.store.checkpoint(run.checkpoint_sha256) if run.checkpoint_sha256 else result.agent
    (loaded,) = load_agents(agent, get_scenario(task.scenario))
    with one_torch_thread():
        return play_task(loaded.agent, task, seeds, OPTIONS[result.option] if result.option else None)
