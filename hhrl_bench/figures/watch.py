"""One test episode as a picture: a GIF that moves, or a PNG strip of key frames above speed and distance over time."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hhrl_agents import Agent
from hhrl_agents.atomic_files import OutputError, require_writable, write_atomically
from hhrl_bench.evaluation.decisions import Trace, episodes_of, recordings
from hhrl_bench.evaluation.evidence import read_evidence
from hhrl_bench.evaluation.paired_evaluation import evaluation_slots, rollout_of_episode
from hhrl_bench.evaluation.results import Update, silent
from hhrl_bench.evaluation.rollout import Rollout
from hhrl_bench.evaluation.store import Store
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.tasks.tasks import AnyTask, Task, get_task
from hhrl_envs import Option, Outcome, get_scenario
from hhrl_envs.errors import require
from hhrl_envs.rendering.snapshot import Snapshot, snapshot_of


def watch(
    agent: Agent,
    task: AnyTask,
    out: str | Path,
    episode: int = 0,
    option: Option | None = None,
    update: Update = silent,
) -> Outcome:
    """Return how test episode ``episode`` of the task ends, having drawn it into the file ``out``.

    Args:
        agent: the agent that drives; see :class:`hhrl_agents.Agent`.
        task: what names a task; see :func:`hhrl_bench.tasks.tasks.get_task`.
        out: a ``.gif`` (every step, in real time) or a ``.png`` (a strip of key frames).
        episode: which test episode, as :func:`hhrl_bench.evaluate` counts them.
        option: hold this option fixed in place of the agent's own choice.
        update: hears how many steps are done of how many there can be, then how many pictures are drawn.

    Raises:
        InputError: in one line, for anything that cannot be played or written.
    """
    path = Path(out)
    draw = artist(path)
    require_writable(path)
    snapshots = record(agent, get_task(task), episode, option, update)
    write_atomically(path, draw(snapshots, update))
    return snapshots[-1].outcome


def record(
    agent: Agent, task: Task, episode: int, option: Option | None = None, update: Update = silent
) -> list[Snapshot]:
    """Return every snapshot of one test episode, from its start to its outcome, with the option selected there.

    It is run in the batch that the evaluation runs it in, so that it is the same to the last bit.
    """
    return snapshots_of(*rollout_of_episode(agent, task, episode, option), update)


def snapshots_of(rollout: Rollout, row: int, update: Update = silent) -> list[Snapshot]:
    """Return every snapshot of one row of a rollout, before the first step and after each, until its outcome.

    Each has the option of the ego that is selected there; the last one that of the last step. ``update`` hears how many
    steps are done, of how many there can be.
    """
    snapshots = [snapshot_of(rollout.simulator, row)]
    for step in rollout:
        ended = snapshot_of(step.simulator, row, int(step.first.option[row]))
        snapshots[-1] = replace(snapshots[-1], option=ended.option)
        snapshots.append(ended)
        update(len(snapshots) - 1, step.simulator.scenario.horizon, "")
        if not (step.simulator.agent_outcomes[row] == Outcome.RUNNING).any():
            break
    return snapshots


def artist(path: Path) -> Callable[[Sequence[Snapshot], Update], bytes]:
    """Return the function that draws what the suffix of ``path`` asks for."""
    if path.suffix.lower() not in {".gif", ".png"}:
        raise OutputError(f"cannot draw {path.name!r}; write a name that ends in .gif or .png")
    require("pygame", extra="render")
    require("PIL", extra="render")
    from hhrl_bench.figures import filmstrip  # noqa: PLC0415  (the extra is needed only from here on)

    return filmstrip.gif if path.suffix.lower() == ".gif" else filmstrip.png


def replayed(task: Task, episode: int, trace: Trace, update: Update = silent) -> list[Snapshot]:
    """Return every snapshot of a test episode, given the trace of that episode alone."""
    agent, drivers = recordings(trace, evaluation_slots(task))
    seeds = task.test.take(1, offset=episode)
    return snapshots_of(Rollout(agent, get_scenario(task.scenario), seeds, drivers=drivers), 0, update)


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
    for run in board.find(agent, task).runs:
        evidence = read_evidence(run, store)
        for episode in np.flatnonzero(evidence.outcome != Outcome.SUCCESS):
            seed = run.training.seed if run.training else None
            yield Failure(seed, int(episode), episodes_of(evidence.trace, slice(episode, episode + 1)))


def film_failures(
    board: LeaderboardRecord, store: Store, agent: str, task: str, count: int, out: Path, update: Update = silent
) -> Iterator[tuple[Path, Outcome]]:
    """Return the films of the first ``count`` failures as they are drawn, and how each ends; see ``failures``.

    ``update`` hears of each how many steps are done, and how many pictures are drawn.
    ``out`` is a ``.gif`` or a ``.png``; the films lie beside it, with the training seed and episode in their names.
    """
    draw, chosen = artist(out), get_task(task)
    require_writable(out)
    for failure in islice(failures(board, store, agent, chosen.id), count):
        snapshots = replayed(chosen, failure.episode, failure.trace, update)
        write_atomically(failure.name(out), draw(snapshots, update))
        yield failure.name(out), snapshots[-1].outcome
