"""Verification of an entry: what it says, computed again from what it rests on, level by level, offline."""

from collections.abc import Iterator

import numpy as np

from hhrl_bench.checked_result import CheckedResult
from hhrl_bench.derived import derived
from hhrl_bench.differences import Finding, differences
from hhrl_bench.errors import RecordError
from hhrl_bench.leaderboard_record import LeaderboardRecord
from hhrl_bench.level import Level
from hhrl_bench.progress import Update, silent
from hhrl_bench.records import TaskRecord
from hhrl_bench.rerunning import rerun
from hhrl_bench.results import task_record
from hhrl_bench.statistics import CONFIDENCE
from hhrl_bench.store import Store
from hhrl_bench.summaries import BOOTSTRAP_SEED
from hhrl_bench.tasks import SCRIPTED, get_task
from hhrl_bench.transfer_rows import recompute


def verify(
    board: LeaderboardRecord,
    store: Store,
    level: Level,
    update: Update = silent,
    sample: int | None = None,
    seed: int = 0,
) -> Iterator[Finding]:
    """Return what does not hold in an entry, whose files lie in ``store``; nothing if it is verified up to ``level``.

    ``update`` hears how many results are done. Of the results, ``sample`` are run again, drawn by ``seed``; or all.
    """
    yield from _check_version(board)
    if level == Level.SCHEMA:
        return
    tasks = {task.id: task for task in board.tasks}
    results = [
        CheckedResult(f"results[{index}]", result, tasks[result.task], store, board.checkpoints_published)
        for index, result in enumerate(board.results)
    ]
    count = len(results) if sample is None else min(sample, len(results))
    again = np.random.default_rng(seed).permutation(len(results))[:count] if level.includes(Level.RERUN) else ()
    for index, result in enumerate(results):
        yield from result.recompute()
        if level.includes(Level.REPLAYED):
            yield from result.replay()
        if index in again:
            yield from rerun(result)
        update(index + 1, len(results), f"{result.result.agent} on {result.result.task}")
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
        found = derived(board.results, board.trainings, store, checkpoints=board.checkpoints_published)
    except RecordError:  # a file is missing or damaged, which its result has said
        return
    names = (*found, *(["transfer"] if board.transfer else []))
    transfer = {"transfer": recompute(board.transfer)} if board.transfer else {}
    again = board.model_copy(update=found | transfer).model_dump(include=set(names))
    yield from differences("", board.model_dump(include=set(names)), again)
