"""The status of a study: what its board says, for whoever asks while it runs or afterwards."""

from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

from rich.console import Console

from hhrl_bench.board import Board, StudyStatus, UnitStatus
from hhrl_bench.executors import Execution
from hhrl_bench.study import Study
from hhrl_bench.study_view import Tally, unit_table
from hhrl_envs.errors import one_line

FOLDER = "progress"


def study_board(folder: Path) -> Board:
    """Return the board of the study whose trainings lie in ``folder``."""
    return Board(folder / FOLDER)


def study_status(study: Study, execution: Execution) -> StudyStatus:
    """Return what a study that begins now has to do."""
    units = tuple(one_line(unit.name) for stage in study.stages for unit in stage)
    started = datetime.now(UTC).isoformat(timespec="seconds")
    return StudyStatus(study=study.name, executor=execution.executor, started=started, units=units)


def print_status(console: Console, board: Board) -> None:
    """Return nothing; print how many units are done, and how far each is that runs or why it has failed.

    Raises:
        RecordError: in one line, if the board is none.
    """
    study = board.study()
    units = [status for name in study.units if (status := board.unit(name))]
    tally = Tally(len(study.units))
    for status in units:
        tally.add(status)
    at_work = board.is_open()
    running = [status for status in units if status.state == "running"]
    state = f"at work since {study.started}" if at_work else "no run is at work"
    text = f"suite {study.study}: {tally.text(running if at_work else ())} ({study.executor}, {state})"
    console.print(text, markup=False, highlight=False, soft_wrap=True)
    rest = [_stopped(status, at_work=at_work) for status in (*running, *_failed(units))]
    if rest:
        console.print(unit_table(rest))


def _failed(units: Sequence[UnitStatus]) -> list[UnitStatus]:
    return [status for status in units if status.state == "failed"]


def _stopped(status: UnitStatus, *, at_work: bool) -> UnitStatus:
    """Return the status of a unit, which says so if nobody goes on with it."""
    if at_work or status.state != "running":
        return status
    return status.model_copy(update={"note": f"stopped; {status.note}".rstrip("; ")})
