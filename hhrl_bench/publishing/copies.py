"""Runs under somebody's own name whose episodes are another agent's.

Two agents may drive alike in some worlds. Of the published ones with different names and weights, no two runs share
half of their episodes. A run that shares more with another agent's has that agent's decisions.
"""

import hashlib
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hhrl_bench.evaluation.decisions import Trace
from hhrl_bench.evaluation.evidence import read_evidence
from hhrl_bench.evaluation.records import ResultRecord
from hhrl_bench.evaluation.store import Store
from hhrl_bench.leaderboard.findings import Finding
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.verification.identity import named
from hhrl_envs.errors import InputError

MOST_ALIKE = 0.5
"""The share of the episodes of a task that runs of two agents may have in common."""


class Stored(NamedTuple):
    """An entry, and the store beside it."""

    board: LeaderboardRecord
    store: Store


class PlayedRun(NamedTuple):
    """A run on a task at a place in an entry of a suite; a number stands for the ego's actions in each episode."""

    entry: str
    suite: str
    agent: str
    own: bool
    place: str
    episodes: NDArray[np.uint64]

    def is_rival(self, other: "PlayedRun") -> bool:
        """Return whether another run is of somebody else's agent.

        In the same entry that is a registered one, and in another one whatever has another name or the same suite.
        """
        if self.entry == other.entry:
            return not other.own
        return self.agent != other.agent or self.suite == other.suite


def copied(entries: Mapping[str, Stored], of: str | None = None) -> Iterator[Finding]:
    """Yield which runs of a user's own agents have another agent's episodes, in entries by the names of their files.

    Options do not count, since nobody sees them on the road. Registered names need no such look: their decisions are
    made again. Evidence that cannot be read is passed over, as verification says so. ``of``: the only entry whose runs
    are looked at, or those of all.
    """
    boards = [entries[name].board for name in entries if of in {None, name}]
    for task in dict.fromkeys(result.task for board in boards for result in board.results if _is_own(result)):
        runs = [run for name, entry in entries.items() for run in runs_on(name, entry, task)]
        for run in (run for run in runs if run.own and of in {None, run.entry}):
            rivals = [other for other in runs if run.is_rival(other)]
            shares = [shared(run, other) for other in rivals]
            if (share := max(shares, default=0.0)) > MOST_ALIKE:
                first, place = rivals[shares.index(share)], f"{run.entry} {run.place}.evidence_sha256"
                yield Finding(place, f"{share:.0%} of its episodes are those of {first.agent} in {first.entry}")


def shared(run: PlayedRun, other: PlayedRun) -> float:
    """Return the share of the worlds that two runs on a task have both played in which the ego does the same."""
    count = min(len(run.episodes), len(other.episodes))
    return float(np.mean(run.episodes[:count] == other.episodes[:count]))


def _is_own(result: ResultRecord) -> bool:
    """Return whether an agent is a user's own: none that is registered."""
    says = named(result.agent, result.kind)
    return says.kind in {"learned", "factory"} and says.method is None


def runs_on(name: str, entry: Stored, task: str) -> Iterator[PlayedRun]:
    """Yield the runs on a task of an entry of this name whose evidence can be read."""
    for index, result in enumerate(entry.board.results):
        for number, run in enumerate(result.runs if result.task == task else ()):
            place, suite = f"results[{index}].runs[{number}]", entry.board.suite
            try:
                episodes = _episodes(read_evidence(run, entry.store).trace)
            except InputError:
                continue
            yield PlayedRun(name, suite, result.agent, _is_own(result), place, episodes)


def _episodes(trace: Trace) -> NDArray[np.uint64]:
    """Return a number for the ego's actions in each of N episodes, uint64 [N]."""
    ego = np.split(np.ascontiguousarray(trace.actions[:, 0]), np.cumsum(trace.steps)[:-1])
    digests = (hashlib.blake2b(actions.tobytes(), digest_size=8).digest() for actions in ego)
    return np.frombuffer(b"".join(digests), np.uint64)
