"""Agents of an entry run again, in the same worlds or in others."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hhrl_bench.evaluation.decisions import Trace
from hhrl_bench.evaluation.evaluate import Played, play_task
from hhrl_bench.evaluation.guarded_agent import OPTIONS
from hhrl_bench.evaluation.loading import load_agents
from hhrl_bench.evaluation.records import RunRecord
from hhrl_bench.leaderboard.findings import Finding
from hhrl_bench.tasks.seeds import UInt64Array
from hhrl_bench.torch_threads import one_torch_thread
from hhrl_bench.verification.checked_result import CheckedResult
from hhrl_envs import get_scenario
from hhrl_envs.errors import InputError

SAME = 0.9
"""The share of episodes in which an agent has to decide the same again; another machine may round differently."""


def rerun(checked: CheckedResult) -> Iterator[Finding]:
    """Return the runs that do not decide the same again in ``SAME`` of the episodes, of a result that is playable."""
    if not checked.playable:
        return
    for (place, run), evidence in zip(checked.runs(), checked.evidence, strict=True):
        if evidence is None:
            continue
        try:
            same = np.mean(same_episodes(evidence.trace, play(checked, run, checked.seeds).trace))
        except InputError as error:
            yield Finding(place, f"cannot be run again: {error}")
            continue
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


def play(checked: CheckedResult, run: RunRecord, seeds: UInt64Array) -> Played:
    """Return what a run's agent does in these worlds."""
    result, task = checked.result, checked.task
    agent: str | Path = checked.store.checkpoint(run.checkpoint_sha256) if run.checkpoint_sha256 else result.agent
    (loaded,) = load_agents(agent, get_scenario(task.scenario))
    with one_torch_thread():
        return play_task(loaded.agent, task, seeds, OPTIONS[result.option] if result.option else None)
