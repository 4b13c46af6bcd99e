"""The figures of a leaderboard file. Needs the ``report`` extra."""

from collections.abc import Callable
from itertools import groupby
from pathlib import Path

from hhrl_bench.evaluation.evidence import read_evidence
from hhrl_bench.evaluation.results import Update, silent
from hhrl_bench.evaluation.store import Store
from hhrl_bench.figures.episode import save_episode, typical_episode
from hhrl_bench.figures.pareto import save_pareto
from hhrl_bench.figures.style import save_figure, style
from hhrl_bench.figures.table_one import save_table_one
from hhrl_bench.figures.training import save_training_curves, save_trainings
from hhrl_bench.figures.transfers import draw_transfer_curves, draw_transfer_matrix
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.tasks.tasks import registered_task
from hhrl_bench.transfer.records import TransferSetRecord

EXAMPLE = "hybrid-hrl"
"""The agent whose typical episode is shown."""


def save_leaderboard_figures(
    board: LeaderboardRecord, store: Store, folder: Path, update: Update = silent
) -> list[Path]:
    """Draw the figures of a leaderboard into a folder, made if need be, as SVG and PNG, and return the files.

    ``store`` has the files that the leaderboard names; there are no files if nothing in the leaderboard has a figure.
    ``update`` hears how many kinds of figures are drawn.

    Raises:
        RecordError: if a file of the store is missing or damaged.
        OutputError: if a file cannot be written.
    """
    transfer, trainings = board.transfer, board.trainings
    kinds: list[Callable[[], list[Path]]] = (
        [lambda: save_transfer_figures(transfer, folder)]
        if transfer
        else [lambda: save_table_one(board, folder), lambda: save_pareto(board, folder)]
    )
    if trainings:
        kinds += [lambda: save_training_curves(trainings, folder), lambda: save_trainings(trainings, folder)]
    kinds += [lambda: _save_example(board, store, folder)]
    written: list[Path] = []
    for done, save in enumerate(kinds, start=1):
        written += save()
        update(done, len(kinds), "")
    return written


def _save_example(board: LeaderboardRecord, store: Store, folder: Path) -> list[Path]:
    """Draw the typical episode of the lowest training seed of EXAMPLE, if its checkpoint is published."""
    examples = [(result.task, run) for result in board.results if result.agent == EXAMPLE for run in result.runs]
    for task, run in examples[:1]:
        if run.checkpoint_sha256 and run.evidence_sha256 and board.checkpoints_published:
            evidence = read_evidence(run, store)
            episode = typical_episode(evidence.outcome, evidence.trace.steps)
            return save_episode(store.checkpoint(run.checkpoint_sha256), registered_task(task), episode, folder)
    return []


def save_transfer_figures(record: TransferSetRecord, folder: Path) -> list[Path]:
    """Draw the curves of every method and source and the matrix of every method, and return the files, SVG and PNG.

    Raises:
        OutputError: if one cannot be written.
    """
    written: list[Path] = []
    rows = sorted(record.rows, key=lambda row: row.group)
    with style():
        for method, own in groupby(rows, key=lambda row: row.method):
            matrix = list(own)
            for source, curves in groupby(matrix, key=lambda row: row.source):
                written += save_figure(draw_transfer_curves(list(curves)), folder, f"transfer-curves-{method}-{source}")
            written += save_figure(draw_transfer_matrix(matrix), folder, f"transfer-matrix-{method}")
    return written
