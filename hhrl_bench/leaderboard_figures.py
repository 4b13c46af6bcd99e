"""The figures of a leaderboard file. Needs the ``report`` extra."""

from pathlib import Path

from hhrl_bench.errors import RecordError
from hhrl_bench.leaderboard_record import LeaderboardRecord
from hhrl_bench.pareto_figure import save_pareto
from hhrl_bench.table_one_figure import save_table_one
from hhrl_bench.training_curves_figure import save_training_curves
from hhrl_bench.training_outcomes_figure import save_trainings
from hhrl_bench.transfer_figures import save_transfer_figures


def save_leaderboard_figures(board: LeaderboardRecord, folder: Path) -> list[Path]:
    """Return the files written into the folder, SVG and PNG, which is made where there is none.

    Raises:
        RecordError: if nothing in the leaderboard has a figure.
        OutputError: if a file cannot be written.
    """
    written = save_transfer_figures(board.transfer, folder) if board.transfer else _save_scores(board, folder)
    if board.trainings:
        written += [*save_training_curves(board.trainings, folder), *save_trainings(board.trainings, folder)]
    if not written:
        raise RecordError(f"the leaderboard of {board.suite} has one agent a task and no curves: nothing to draw")
    return written


def _save_scores(board: LeaderboardRecord, folder: Path) -> list[Path]:
    return [*save_table_one(board, folder), *save_pareto(board, folder)]
