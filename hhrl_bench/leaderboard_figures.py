"""The figures of a leaderboard file. Needs the ``report`` extra."""

from pathlib import Path

from hhrl_bench.episode_figure import save_episode, typical_episode
from hhrl_bench.evidence import read_evidence
from hhrl_bench.leaderboard_record import LeaderboardRecord
from hhrl_bench.pareto_figure import save_pareto
from hhrl_bench.store import Store
from hhrl_bench.table_one_figure import save_table_one
from hhrl_bench.training_curves_figure import save_training_curves
from hhrl_bench.training_outcomes_figure import save_trainings
from hhrl_bench.transfer_figures import save_transfer_figures

EXAMPLE = "hybrid-hrl"
"""The agent whose typical episode is shown."""


def save_leaderboard_figures(board: LeaderboardRecord, store: Store, folder: Path) -> list[Path]:
    """Return the files written into the folder, SVG and PNG, which is made where there is none.

    ``store`` has the files that the leaderboard names; there are no files if nothing in the leaderboard has a figure.

    Raises:
        RecordError: if a file of the store is missing or damaged.
        OutputError: if a file cannot be written.
    """
    written = save_transfer_figures(board.transfer, folder) if board.transfer else _save_scores(board, folder)
    if board.trainings:
        written += [*save_training_curves(board.trainings, folder), *save_trainings(board.trainings, folder)]
    return [*written, *_save_example(board, store, folder)]


def _save_example(board: LeaderboardRecord, store: Store, folder: Path) -> list[Path]:
    """Draw the typical episode of the lowest training seed of EXAMPLE, if its checkpoint is published."""
    examples = [(result.task, run) for result in board.results if result.agent == EXAMPLE for run in result.runs]
    for task, run in examples[:1]:
        if run.checkpoint_sha256 and run.evidence_sha256 and board.checkpoints_published:
            evidence = read_evidence(run, store)
            episode = typical_episode(evidence.outcome, evidence.trace.steps)
            return save_episode(store.checkpoint(run.checkpoint_sha256), task, episode, folder)
    return []


def _save_scores(board: LeaderboardRecord, folder: Path) -> list[Path]:
    return [*save_table_one(board, folder), *save_pareto(board, folder)]
