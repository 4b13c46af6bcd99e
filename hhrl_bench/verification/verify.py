"""Verification of an entry: what it says, computed again from what it rests on, level by level, offline."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from hhrl_bench.errors import UnknownTaskError
from hhrl_bench.evaluation.results import Update, silent, task_record
from hhrl_bench.evaluation.store import Store
from hhrl_bench.execution.pools import Each
from hhrl_bench.leaderboard.findings import Finding, differences
from hhrl_bench.leaderboard.level import Level
from hhrl_bench.leaderboard.record import LeaderboardRecord, derived_fields
from hhrl_bench.statistics.intervals import BOOTSTRAP_SEED, CONFIDENCE
from hhrl_bench.transfer.summary import recompute
from hhrl_bench.verification.checked_result import CheckedResult, checked_results, played_task
from hhrl_bench.verification.curves import check_curves, check_validation
from hhrl_bench.verification.identity import check_identity, check_weights, playable, repeatable, shipped
from hhrl_bench.verification.rerun import rerun
from hhrl_bench.verification.retrained import retrain
from hhrl_envs.errors import InputError


def verify(
    board: LeaderboardRecord,
    store: Store,
    level: Level,
    update: Update = silent,
    sample: int | None = None,
    seed: int = 0,
    each: Each = map,
) -> Iterator[Finding]:
    """Return what does not hold in an entry, whose files lie in ``store``; nothing if it is verified up to ``level``.

    ``update`` hears how much is done. Of the results, ``sample`` are run again, drawn by ``seed``, or all; at the level
    retrained all are, and ``sample`` of the seeds are trained again. ``each`` checks results, as ``map`` does; see
    :func:`hhrl_bench.execution.pools.mapping`.
    """
    try:
        yield from _check_version(board)
    except UnknownTaskError as error:
        yield Finding("tasks", str(error))
        return
    yield from check_identity(board)
    yield from check_curves(board)
    if level == Level.SCHEMA:
        return
    yield from check_weights(board, store)
    yield from check_validation(board, store)
    results = checked_results(board, store)
    count = len(results) if sample is None or level.includes(Level.RETRAINED) else min(sample, len(results))
    again = np.random.default_rng(seed).permutation(len(results))[:count] if level.includes(Level.RERUN) else ()
    readable = True
    flags = [index in again for index in range(len(results))]
    for index, (findings, was_read) in enumerate(each(partial(check_result, level), results, flags)):
        yield from findings
        readable &= was_read
        result = results[index].result
        update(index + 1, len(results), f"{result.agent} on {result.task}")
    if readable:
        yield from _check_derived(board, store)
    if level.includes(Level.RETRAINED):
        yield from retrain(board, store, update, sample, seed, each)


def check_result(level: Level, result: CheckedResult, again: bool) -> tuple[list[Finding], bool]:
    """Return what does not hold in a result, and whether its evidence was read; ``again``: its agents are run again."""
    replayed = level.includes(Level.REPLAYED)
    findings = list(result.recompute(replayed=replayed))
    if replayed:
        findings += result.replay()
    if again:
        findings += rerun(result)
    readable = result.readable
    result.forget()
    return findings, readable


def reached(board: LeaderboardRecord, level: Level) -> Level:
    """Return how far an entry in which nothing was found is verified by a check up to ``level``.

    Decisions of agents that cannot be run are replayed at most, and trainings that cannot be repeated run at most.
    """
    if not all(playable(result, checkpoints=board.checkpoints_published) for result in board.results):
        return level.at_most(Level.REPLAYED)
    trainings = [run.training for result in board.results for run in result.runs if run.training]
    return level if all(map(repeatable, trainings)) else level.at_most(Level.RERUN)


def _check_version(board: LeaderboardRecord) -> Iterator[Finding]:
    yield from differences("confidence", board.confidence, CONFIDENCE)
    yield from differences("bootstrap_seed", board.bootstrap_seed, BOOTSTRAP_SEED)
    for index, task in enumerate(board.tasks):
        found = task_record(played_task(task), task.episodes)
        yield from differences(f"tasks[{index}]", task.model_dump(), found.model_dump())
    yield from differences("checkpoints_published", board.checkpoints_published, board.transfer is None)
    if board.transfer:
        yield from differences("transfer.bootstrap_seed", board.transfer.bootstrap_seed, BOOTSTRAP_SEED)
    yield from _check_failed(board)


def _check_failed(board: LeaderboardRecord) -> Iterator[Finding]:
    """Yield the results that have other seeds, with those that failed, than their learning curves.

    What comes with the package has no failed seeds.
    """
    curves = {(one.method, one.task): one.seeds for one in board.trainings}
    if board.transfer:
        curves |= {(f"{row.method} {row.arm}", row.target): row.seeds for row in board.transfer.rows}
    for index, result in enumerate(board.results):
        if seeds := curves.get((result.agent, result.task)):
            failed = tuple(seed for seed in seeds if seed not in result.seeds)
            yield from differences(f"results[{index}].failed_seeds", result.failed_seeds, failed)
        elif result.failed_seeds and [run.checkpoint_sha256 for run in result.runs] == shipped(result.agent):
            yield from differences(f"results[{index}].failed_seeds", result.failed_seeds, ())


def _check_derived(board: LeaderboardRecord, store: Store) -> Iterator[Finding]:
    published = board.checkpoints_published
    yield from _check_again(
        "results, trainings",
        board,
        lambda: derived_fields(board.results, board.trainings, store, checkpoints=published),
    )
    if transfer := board.transfer:
        yield from _check_again("transfer", board, lambda: {"transfer": recompute(transfer)})


def _check_again(place: str, board: LeaderboardRecord, compute: Callable[[], dict[str, Any]]) -> Iterator[Finding]:
    """Yield in which fields, computed again from what stands at ``place``, a leaderboard differs."""
    try:
        found = compute()
    except InputError as error:
        yield Finding(place, f"what follows from them cannot be computed: {error}")
        return
    again = board.model_copy(update=found).model_dump(include=set(found))
    yield from differences("", board.model_dump(include=set(found)), again)
