"""A leaderboard as one HTML page that needs nothing else: tables, figures, settings, provenance.

Needs the ``report`` extra. The page loads nothing and runs nothing; equal leaderboards give equal bytes.
"""

import json
from base64 import b64encode
from collections.abc import Iterator, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from jinja2 import Environment, PackageLoader, StrictUndefined

from hhrl_bench.evaluation.records import TaskRecord
from hhrl_bench.evaluation.results import Update, silent
from hhrl_bench.evaluation.store import Store
from hhrl_bench.figures.leaderboard import save_leaderboard_figures
from hhrl_bench.leaderboard.record import LeaderboardRecord, compared_to_best
from hhrl_bench.tables.comparisons import comparison_tables
from hhrl_bench.tables.learning import OUTCOMES_TITLE, efficiency_table, outcome_tables
from hhrl_bench.tables.results import further_tables, results_table, runs_table, sensitivity_tables
from hhrl_bench.tables.success import spans_tasks, success_table
from hhrl_bench.tables.table import Table, joined
from hhrl_bench.tables.transfers import transfer_tables
from hhrl_bench.tasks.seeds import format_seeds
from hhrl_bench.text import NONE

LARGEST_SVG = 90_000
"""Bytes; a figure whose SVG has more is shown as a PNG."""


class Picture(NamedTuple):
    """A figure: its name, and a data URI that holds it."""

    name: str
    uri: str


class TaskSection(NamedTuple):
    """What stands on the page of a task: its tables, and every training seed."""

    task: TaskRecord
    tables: tuple[Table, ...]
    runs: Table


def html(board: LeaderboardRecord, store: Store, update: Update = silent) -> str:
    """Return the page of a leaderboard, whose files lie in a store; ``update`` hears how many figures are drawn.

    Raises:
        RecordError: if one of the files that figures are drawn from is missing or damaged.
    """
    environment = Environment(
        loader=PackageLoader("hhrl_bench.publishing"),
        autoescape=True,  # names of agents and tasks are anybody's
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template("report.html").render(
        board=board,
        dash=NONE,
        agents=list(dict.fromkeys(result.agent for result in board.results)),
        seeds=_seeds(board),
        overview=success_table(board.tasks, [board]) if spans_tasks(board) else None,
        sections=[_section(board, task) for task in board.tasks],
        learning=list(_learning(board)),
        figures=_figures(board, store, update),
        settings=[(method, list(_flat(method.config))) for method in board.methods],
    )


def _section(board: LeaderboardRecord, task: TaskRecord) -> TaskSection:
    results = board.on(task)
    shown = [results_table(task, results, seeds=True), *further_tables(task, results)]
    shown += sensitivity_tables(board.sensitivity, task)
    shown += comparison_tables(compared_to_best(board, task))
    return TaskSection(task, tuple(shown), runs_table(results))


def _learning(board: LeaderboardRecord) -> Iterator[Table]:
    """Yield the tables of what learning took and what it is worth elsewhere."""
    if board.efficiency:
        yield efficiency_table(board.efficiency)
    if board.trainings:
        yield joined(OUTCOMES_TITLE, outcome_tables(board.trainings))
    if board.transfer:
        yield from transfer_tables(board.transfer.rows)


def _seeds(board: LeaderboardRecord) -> list[str]:
    """Return the training seeds of the results, each set of them once."""
    return list(dict.fromkeys(format_seeds(result.seeds) for result in board.results if result.seeds))


def _figures(board: LeaderboardRecord, store: Store, update: Update) -> list[Picture]:
    """Return the figures of a leaderboard; none if it has nothing to draw."""
    with TemporaryDirectory() as folder:
        written = save_leaderboard_figures(board, store, Path(folder), update)
        return [_figure(path) for path in written if path.suffix == ".svg"]


def _figure(path: Path) -> Picture:
    vector = path.read_bytes()
    small = len(vector) <= LARGEST_SVG
    kind, content = ("svg+xml", vector) if small else ("png", path.with_suffix(".png").read_bytes())
    return Picture(path.stem.replace("-", " "), f"data:image/{kind};base64,{b64encode(content).decode()}")


def _flat(config: Mapping[str, Any], under: str = "") -> Iterator[tuple[str, str]]:
    """Yield every setting, by its path, as JSON."""
    for key, value in config.items():
        if isinstance(value, Mapping) and value:
            yield from _flat(value, f"{under}{key}.")
        else:
            yield f"{under}{key}", json.dumps(value, ensure_ascii=False)
