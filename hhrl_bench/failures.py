"""The failures of a published entry, filmed from its stored decisions: no agent is needed, nor what it needs."""

from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hhrl_agents.files import require_writable, write_atomically
from hhrl_bench.casting import evaluation_slots
from hhrl_bench.errors import RecordError
from hhrl_bench.evidence import read_evidence
from hhrl_bench.leaderboard_record import LeaderboardRecord
from hhrl_bench.stage import Stage
from hhrl_bench.store import Store
from hhrl_bench.tasks import get_task
from hhrl_bench.traces import Trace, episode_of, recordings
from hhrl_bench.watch import artist, moments_of
from hhrl_envs import Outcome, get_scenario


class Failure(NamedTuple):
    """A test episode that did not succeed: of which training seed, None without one, and what was decided in it."""

    seed: int | None
    episode: int
    trace: Trace

    def name(self, out: Path) -> Path:
        """Return the path of its film beside ``out``."""
        seed = "" if self.seed is None else f"-seed-{self.seed}"
        return out.with_stem(f"{out.stem}{seed}-episode-{self.episode}")


def failures(board: LeaderboardRecord, store: Store, agent: str, task: str) -> Iterator[Failure]:
    """Return the failures of an agent on a task, by training seed and episode.

    Raises:
        RecordError: if the entry has no such result, or its evidence is missing or damaged.
    """
    found = [result for result in board.results if (result.agent, result.task) == (agent, task)]
    if not found:
        known = ", ".join(f"{result.agent} on {result.task}" for result in board.results)
        raise RecordError(f"the entry has no {agent} on {task}; it has {known}")
    for run in found[0].runs:
        evidence = read_evidence(run, store)
        for episode in np.flatnonzero(evidence.outcome != Outcome.SUCCESS):
            seed = run.training.seed if run.training else None
            yield Failure(seed, int(episode), episode_of(evidence.trace, int(episode)))


def film_failures(
    board: LeaderboardRecord, store: Store, agent: str, task: str, count: int, out: Path
) -> Iterator[tuple[Path, Outcome]]:
    """Return the films of the first ``count`` failures as they are drawn, and how each ends; see ``failures``.

    ``out`` is a ``.gif`` or a ``.png``; the films lie beside it, with the training seed and episode in their names.
    """
    draw, chosen = artist(out), get_task(task)
    require_writable(out)
    for failure in islice(failures(board, store, agent, task), count):
        recording, cast = recordings(failure.trace, evaluation_slots(chosen))
        stage = Stage(recording, get_scenario(chosen.scenario), 1, cast=cast)
        stage.begin(chosen.test.take(1, offset=failure.episode))
        moments = moments_of(stage, 0)
        write_atomically(failure.name(out), draw(moments))
        yield failure.name(out), moments[-1].outcome
