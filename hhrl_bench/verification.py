"""Verification of an entry: what it says, computed again from what it rests on, level by level, offline."""

from collections.abc import Iterator
from enum import StrEnum

from hhrl_bench.checked_result import CheckedResult
from hhrl_bench.derived import derived
from hhrl_bench.differences import Finding, differences
from hhrl_bench.errors import RecordError
from hhrl_bench.leaderboard_record import LeaderboardRecord
from hhrl_bench.progress import Update, silent
from hhrl_bench.records import TaskRecord
from hhrl_bench.rerunning import rerun
from hhrl_bench.results import task_record
from hhrl_bench.statistics import CONFIDENCE
from hhrl_bench.store import Store
from hhrl_bench.summaries import BOOTSTRAP_SEED
from hhrl_bench.tasks import SCRIPTED, get_task
from hhrl_bench.transfer_rows import recompute


class Level(StrEnum):
    """How far an entry is verified; each level includes those before it.

    schema: it is well-formed, and its tasks are those of this version. recomputed: all that follows from the whole
    numbers of the episodes, from the learning curves and from each other. replayed: the stored decisions, played
    through the simulator again, come to every number of every result. rerun: the agents decide the same again.
    """

    SCHEMA = "schema"
    RECOMPUTED = "recomputed"
    REPLAYED = "replayed"
    RERUN = "rerun"

    def includes(self, other: "Level") -> bool:
        """Return whether this level includes another."""
        return list(Level).index(self) >= list(Level).index(other)


def verify(board: LeaderboardRecord, store: Store, level: Level, update: Update = silent) -> Iterator[Finding]:
    """Return what does not hold in an entry, whose files lie in ``store``; nothing if it is verified up to ``level``.

    ``update`` hears how many results are done.
    """
    yield from _check_version(board)
    if level == Level.SCHEMA:
        return
    tasks = {task.id: task for task in board.tasks}
    results = [
        CheckedResult(f"results[{index}]", result, tasks[result.task], store)
        for index, result in enumerate(board.results)
    ]
    for done, result in enumerate(results, start=1):
        yield from result.recompute()
        if level.includes(Level.REPLAYED):
            yield from result.replay()
        if level.includes(Level.RERUN):
            yield from rerun(result)
        update(done, len(results), f"{result.result.agent} on {result.result.task}")
    yield from _check_derived(board, store)


def _check_version(board: LeaderboardRecord) -> Iterator[Finding]:
    yield from differences("confidence", board.confidence, CONFIDENCE)
    yield from differences("bootstrap_seed", board.bootstrap_seed, BOOTSTRAP_SEED)
    for index, task in enumerate(board.tasks):
        yield from differences(f"tasks[{index}]", task.model_dump(), _of_this_version(task).model_dump())


def _of_this_version(record: TaskRecord) -> TaskRecord:
    task = get_task(record.id)
    if task.opponent:
        task = task.against(record.opponent.agent if record.opponent else SCRIPTED)
    return task_record(task, record.episodes)


def _check_derived(board: LeaderboardRecord, store: Store) -> Iterator[Finding]:
    try:
        found = derived(board.results, board.trainings, store)
    except RecordError:  # a file is missing or damaged, which its result has said
        return
    names = (*found, *(["transfer"] if board.transfer else []))
    transfer = {"transfer": recompute(board.transfer)} if board.transfer else {}
    again = board.model_copy(update=found | transfer).model_dump(include=set(names))
    yield from differences("", board.model_dump(include=set(names)), again)
