"""Tables in Markdown, and the leaderboards of one suite as a page of such tables."""

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain, repeat
from typing import NamedTuple

from hhrl_bench.evaluation.metrics import METRICS
from hhrl_bench.evaluation.records import ResultRecord, TaskRecord
from hhrl_bench.leaderboard.record import LeaderboardRecord, compared_to_best, standing
from hhrl_bench.tables.comparisons import comparison_tables
from hhrl_bench.tables.learning import efficiency_table
from hhrl_bench.tables.results import further_tables, results_table, sensitivity_tables
from hhrl_bench.tables.success import results_by_row, spans_tasks, success_table
from hhrl_bench.tables.table import Cell, Column, Row, Table
from hhrl_bench.tables.transfers import transfer_tables
from hhrl_bench.text import NONE

_SPECIAL = re.compile(r"([\\`*_\[\]<>|&~$@#]|:(?=//)|(?<=www)\.)", re.IGNORECASE)


class Scored(NamedTuple):
    """A result, and the name of the entry that it is from."""

    entry: str
    result: ResultRecord


def suite_page(boards: Mapping[str, LeaderboardRecord]) -> str:
    """Return a page with the tables of leaderboards by the names of their entries, all of one suite.

    Rows of all entries stand in one table a task, the best first; only what was played in equal worlds is
    put together. Equal leaderboards give equal text.
    """
    suites = " and ".join(dict.fromkeys(board.suite for board in boards.values()))
    tasks = dict.fromkeys(task for board in boards.values() for task in board.tasks)
    made = "\n".join(_made(name, board) for name, board in boards.items())
    blocks = [f"# Leaderboard of the suite {plain(suites)}", f"Each entry, and what made it:\n\n{made}"]
    blocks += _overview(list(tasks), boards)
    for task in tasks:
        blocks += _task(task, boards)
    for name, board in boards.items():
        blocks += _learning(name, board)
    return "\n\n".join(blocks) + "\n"


def markdown_table(table: Table, level: str, entry: str = "") -> Iterator[str]:
    """Yield the blocks of a table: its heading of a ``level`` such as ``##``, its lines, its notes.

    entry: the entry that it is of, for the heading.
    """
    yield f"{level} {plain(table.title)}" + (f", {plain(entry)}" if entry else "")
    lines = [
        _line([table.names, *(column.line for column in table.columns)]),
        "|".join(["", "---", *["---:"] * len(table.columns), ""]),
    ]
    for group in table.groups:
        if group.name:
            lines.append(f"| **{plain(group.name)}** |{' |' * len(table.columns)}")
        lines += [_line([row.full_name, *map(_said, row.cells)]) for row in group.rows]
    yield "\n".join(lines)
    if notes := table.all_notes:
        yield "\n".join(f"- {plain(note.text)}" for note in notes)


def plain(text: str) -> str:
    """Return Markdown that shows a text as it is, on one line, whatever it holds."""
    return _SPECIAL.sub(r"\\\1", " ".join(text.split()))


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(map(plain, cells))} |"


def _said(cell: Cell) -> str:
    return (cell.value or NONE) + (f" ({cell.bounds})" if cell.bounds else "")


def _overview(tasks: Sequence[TaskRecord], boards: Mapping[str, LeaderboardRecord]) -> Iterator[str]:
    """Yield the blocks of what agents do across tasks, if any does several."""
    if any(map(spans_tasks, boards.values())):
        entries = [name for name, board in boards.items() for _ in results_by_row(board)]
        yield from markdown_table(_marked(success_table(tasks, list(boards.values())), entries), "##")


def _task(task: TaskRecord, boards: Mapping[str, LeaderboardRecord]) -> Iterator[str]:
    """Yield the blocks of one task."""
    scored = [Scored(name, one) for name, board in boards.items() if task in board.tasks for one in board.on(task)]
    scored.sort(key=lambda one: standing(one.result), reverse=True)
    results, entries = [one.result for one in scored], [one.entry for one in scored]
    last = task.test_start + task.episodes - 1
    yield f"## {plain(task.id)}"
    yield f"{task.episodes:,} test episodes, the worlds of seeds {task.test_start} to {last}."
    bounded = _bounded(results_table(task, results, seeds=True), METRICS["success"].heading)
    for table in (bounded, *further_tables(task, results)):
        yield from markdown_table(_marked(table, entries), "###")
    for name, board in boards.items():
        if task in board.tasks:
            compared = comparison_tables(compared_to_best(board, task))
            for table in (*sensitivity_tables(board.sensitivity, task), *compared):
                yield from markdown_table(table, "###", name)


def _learning(name: str, board: LeaderboardRecord) -> Iterator[str]:
    """Yield the blocks of what an entry says of learning."""
    tables = [efficiency_table(board.efficiency)] if board.efficiency else []
    for table in [*tables, *(transfer_tables(board.transfer.rows) if board.transfer else [])]:
        yield from markdown_table(table, "##", name)


def _made(name: str, board: LeaderboardRecord) -> str:
    made = board.provenance
    commit = f"commit {made.git_commit}" if made.git_commit else "no commit"
    return f"- {plain(name)}: {plain(made.command)}, version {plain(made.package_version)}, {commit}"


def _marked(table: Table, entries: Sequence[str]) -> Table:
    """Return the table with one more column: the entries of its first rows, which are as many."""
    last = chain(map(Cell, entries), repeat(Cell()))
    groups = [
        group._replace(rows=tuple(row._replace(cells=(*row.cells, next(last))) for row in group.rows))
        for group in table.groups
    ]
    return table._replace(columns=(*table.columns, Column("entry")), groups=tuple(groups))


def _bounded(table: Table, heading: str) -> Table:
    """Return the table with the intervals of one column alone."""
    kept = [column.heading == heading for column in table.columns]

    def bounded(row: Row) -> Row:
        cells = zip(row.cells, kept, strict=True)
        return row._replace(cells=tuple(cell if keep else Cell(cell.value) for cell, keep in cells))

    groups = (group._replace(rows=tuple(map(bounded, group.rows))) for group in table.groups)
    return table._replace(groups=tuple(groups))
