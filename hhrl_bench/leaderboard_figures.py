"""The figures of a leaderboard file. Needs the ``report`` extra."""

from pathlib import Path

from hhrl_bench.errors import RecordError
from hhrl_bench.leaderboard_record import LeaderboardRecord
from hhrl_bench.training_outcomes_figure import save_trainings
from hhrl_bench.transfer_figures import save_transfer_figures


def save_leaderboard_figures(board: LeaderboardRecord, folder: Path) -> list[Path]:
    """Return the files written into the folder, SVG and PNG, which is made where there is none.

    Raises:
        RecordError: if nothing in the leaderboard has a figure.
        OutputError: if a file cannot be written.
    """
    if board.transfer is None and not board.trainings:
        raise RecordError(f"the leaderboard of {board.suite} holds no transfer or training to draw; name one that does")
    folder.mkdir(parents=True, exist_ok=True)
    transfer = save_transfer_figures(board.transfer, folder) if board.transfer else []
    trainings = save_trainings(board.trainings, folder) if board.trainings else []
    return [*transfer, *trainings]
