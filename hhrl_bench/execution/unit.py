"""Units: the smallest pieces of a study's work, and what becomes of one that a process does."""

import errno
import time
from collections.abc import Sequence
from typing import NamedTuple, Protocol

from hhrl_bench.evaluation.records import TimedResult, TrainedSeed
from hhrl_bench.evaluation.results import Update, silent
from hhrl_bench.execution.progress_folder import ProgressFolder, UnitStatus
from hhrl_bench.extensions import load_extensions
from hhrl_bench.tracebacks import show_traceback
from hhrl_envs.errors import InputError, one_line

_FULL = {errno.ENOSPC, errno.EFBIG, errno.EDQUOT}


class Unit(Protocol):
    """A piece of work; all that it needs is in its fields, and what it does depends on nothing else."""

    @property
    def name(self) -> str:
        """What it is called in messages."""

    def check(self) -> None:
        """Raise an ``InputError`` if it is plain from the outset that ``run`` cannot succeed."""

    def run(self, update: Update = silent) -> "Outcome":
        """Return the outcome and the seconds it took; call ``update`` with how far it is."""


Outcome = TimedResult | TrainedSeed
"""What comes of a unit: a result of the leaderboard, or a trained seed."""

Stages = Sequence[Sequence[Unit]]
"""Units in the order in which they can be done: those of a stage need what the stages before it have left."""


class Done(NamedTuple):
    """A unit and its outcome; where there is none, ``failure`` says why.

    ``lost``: whether its process was gone before the unit ended, so that it may succeed elsewhere.
    """

    unit: Unit
    outcome: Outcome | None
    failure: str = ""
    lost: bool = False


def attempt(unit: Unit, folder: ProgressFolder | None) -> Done:
    """Do a unit in this process, write to the progress folder how far it is, and return what became of it."""
    if folder is None:
        return _attempt(unit, silent)
    started = time.perf_counter()
    name = one_line(unit.name)

    def update(done: int, total: int, note: str) -> None:
        seconds = time.perf_counter() - started
        folder.write(
            UnitStatus(unit=name, state="running", done=done, total=total, note=one_line(note), seconds=seconds)
        )

    try:
        with folder.at_work():
            update(0, 0, "")
            done = _attempt(unit, update)
            folder.write(unit_status(done, time.perf_counter() - started))
            return done
    except InputError as error:
        return Done(unit, None, str(error))


def unit_status(done: Done, seconds: float) -> UnitStatus:
    """Return the status of a unit that ended: the seconds of its outcome, or the given ones if it failed."""
    name, outcome = one_line(done.unit.name), done.outcome
    if outcome is None:
        return UnitStatus(unit=name, state="failed", note=one_line(done.failure), seconds=seconds)
    if isinstance(outcome, TimedResult):
        note = f"success {outcome.result.metrics.success.mean:.1%}"
    else:
        note = one_line(outcome.note)
    return UnitStatus(unit=name, state="done", note=note, seconds=outcome.seconds)


def _attempt(unit: Unit, update: Update) -> Done:
    try:
        load_extensions()  # this process may be another than the one that was told of them
        return Done(unit, unit.run(update))
    except Exception as error:  # noqa: BLE001 - the other units go on, and this one is shown as failed
        show_traceback(error)
        return Done(unit, None, _reason(error))


def _reason(error: Exception) -> str:
    if isinstance(error, InputError):
        return str(error) + _advice(error.__cause__)
    if isinstance(error, OSError):
        where = f": {error.filename}" if error.filename else ""
        return f"{error.strerror or error}{where}{_advice(error)}"
    return f"{type(error).__name__}: {error}"


def _advice(error: BaseException | None) -> str:
    full = isinstance(error, OSError) and error.errno in _FULL
    return "; make room there, and run the same command again" if full else ""
