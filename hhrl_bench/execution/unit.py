"""Attempts: a unit done by this process, whatever becomes of it."""

import errno
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple, Protocol

from hhrl_bench.evaluation.records import TimedResult
from hhrl_bench.execution.progress_board import Board, UnitStatus
from hhrl_bench.progress import Update, silent
from hhrl_envs.errors import InputError, one_line

if TYPE_CHECKING:
    pass

_FULL = {errno.ENOSPC, errno.EFBIG, errno.EDQUOT}


class Unit(Protocol):
    """A piece of work; all that it needs is in its fields, and what it does depends on nothing else."""

    @property
    def name(self) -> str:
        """What it is called in messages."""

    def check(self) -> None:
        """Return nothing; raises an InputError where it is plain from the outset that ``run`` cannot succeed."""

    def run(self, update: Update = silent) -> TimedResult:
        """Return the outcome, and the seconds it took; ``update`` hears how far it is."""


class Done(NamedTuple):
    """A unit and its outcome; where there is none, ``failure`` says why.

    ``lost``: whether its worker has gone before the unit has ended, so that it may succeed elsewhere.
    """

    unit: Unit
    outcome: TimedResult | None
    failure: str = ""
    lost: bool = False


def attempt(unit: Unit, board: Board | None) -> Done:
    """Return the unit as this process has done it, or why it has not; how far it is stands on the board, if any."""
    if board is None:
        return _attempt(unit, silent)
    started = time.perf_counter()

    def update(done: int, total: int, note: str) -> None:
        seconds = time.perf_counter() - started
        name, said = one_line(unit.name), one_line(note)
        board.write(UnitStatus(unit=name, state="running", done=done, total=total, note=said, seconds=seconds))

    try:
        with board.at_work():
            update(0, 0, "")
            done = _attempt(unit, update)
            board.write(unit_status(done, time.perf_counter() - started))
            return done
    except InputError as error:
        return Done(unit, None, str(error))


def unit_status(done: Done, seconds: float) -> UnitStatus:
    """Return what the board says of a unit that has ended after these seconds, or took others in an earlier run."""
    name, outcome = one_line(done.unit.name), done.outcome
    if outcome is None:
        return UnitStatus(unit=name, state="failed", note=one_line(done.failure), seconds=seconds)
    note = f"success {outcome.result.metrics.success.mean:.1%}"
    return UnitStatus(unit=name, state="done", note=note, seconds=outcome.seconds)


def _attempt(unit: Unit, update: Update) -> Done:
    try:
        return Done(unit, unit.run(update))
    except InputError as error:
        return Done(unit, None, str(error) + _advice(error.__cause__))
    except OSError as error:
        where = f": {error.filename}" if error.filename else ""
        return Done(unit, None, f"{error.strerror or error}{where}{_advice(error)}")
    except Exception as error:  # noqa: BLE001 - the other units go on, and this one is shown as failed
        return Done(unit, None, f"{type(error).__name__}: {error}")


def _advice(error: BaseException | None) -> str:
    full = isinstance(error, OSError) and error.errno in _FULL
    return "; make room there, and run the same command again" if full else ""


Stages = Sequence[Sequence[Unit]]
"""Units in the order in which they can be done: those of a stage need what the stages before it have left."""
