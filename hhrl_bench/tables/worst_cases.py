"""Worst cases as a table to read: the worst training seed, collisions counted, and how severe episodes get."""

from collections.abc import Sequence

from rich.console import Console
from rich.console import Group as Stack
from rich.table import Table
from rich.text import Text

from hhrl_bench.evaluation.records import ResultRecord, RunRecord, TaskRecord
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.tables.sheet import Cell, Column, Group, Row, Sheet, _lines, metric_cell
from hhrl_bench.tables.success import contestant
from hhrl_bench.tables.terminal import cell_text, print_widest, ruled_table
from hhrl_bench.text import WIDTH, folded

SEVERITY = (
    Column("impact_speed", "impact\nm/s", 2, 2),
    Column("smallest_gap", "smallest\ngap, m", 2, 2),
    Column("smallest_ttc", "smallest\nTTC, s", 2, 2),
)
HEADINGS = ("worst seed's\nsuccess", "collisions", *(column.heading for column in SEVERITY))
"""The first ones are shown longest where there is little room."""

NOTES = (
    "Worst seed: the training seed, in brackets, that succeeds least. Collisions are counted over all seeds.",
    "Impact: the speed relative to the front vehicle, a mean over the collisions.",
    "Gap and TTC, the time to collision: the smallest of every episode, a mean over the episodes.",
)


def worst_run(result: ResultRecord) -> RunRecord:
    """Return the run that succeeds least; of equal ones the first."""
    return min(result.runs, key=lambda run: run.metrics.success)


def detail_cells(task: TaskRecord, result: ResultRecord) -> tuple[Cell, ...]:
    """Return what stands under HEADINGS for a result."""
    worst = worst_run(result)
    seed = f" ({worst.training.seed})" if worst.training and len(result.runs) > 1 else ""
    hits = sum(round(run.metrics.collision * task.episodes) for run in result.runs)
    return (
        Cell(f"{worst.metrics.success:.1%}{seed}"),
        Cell(f"{hits:,} of {len(result.runs) * task.episodes:,}"),
        *(metric_cell(column, getattr(result.metrics, column.key)) for column in SEVERITY),
    )


def print_details(console: Console, board: LeaderboardRecord) -> None:
    """Return nothing; print a table a task, in the widest layout that the console has room for."""
    layouts = [(last, intervals) for intervals in (True, False) for last in range(len(HEADINGS), 0, -1)]
    place = print_widest(console, [_tables(board, *layout) for layout in layouts])
    console.print("\n".join([*NOTES, *["A wider terminal shows more."][: place > 0]]), style="dim", highlight=False)


def _tables(board: LeaderboardRecord, columns: int, intervals: bool) -> Stack:
    tables = [_table(task, board.on(task), columns, intervals) for task in board.tasks]
    return Stack(*(part for table in tables for part in (table, "")))


def _table(task: TaskRecord, results: Sequence[ResultRecord], columns: int, intervals: bool) -> Table:
    table = ruled_table(f"Worst cases on {task.id}, {task.episodes:,} test episodes", intervals=intervals)
    table.add_column("agent", overflow="fold", max_width=WIDTH, vertical="top")
    for heading in HEADINGS[:columns]:
        table.add_column(heading, justify="right", no_wrap=True)
    for result in results:
        cells = detail_cells(task, result)[:columns]
        table.add_row(Text(folded(result.agent)), *(cell_text(cell, intervals=intervals) for cell in cells))
    return table


def details_sheet(task: TaskRecord, results: Sequence[ResultRecord]) -> Sheet:
    """Return the worst training seed of every result, its collisions, and how severe its episodes are."""
    rows = tuple(Row(contestant(result), detail_cells(task, result)) for result in results)
    return Sheet("Worst cases", ("agent", *_lines(HEADINGS)), (Group("", rows),), NOTES)
