"""Leaderboards of one suite as a Markdown page: the same tables wherever they are read."""

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from hhrl_bench.evaluation.records import ResultRecord, TaskRecord
from hhrl_bench.leaderboard.record import LeaderboardRecord, compared_to_best, success
from hhrl_bench.tables import comparisons, efficiency, transfers, worst_cases
from hhrl_bench.tables import results as results_module
from hhrl_bench.tables import success as success_module
from hhrl_bench.tables.sheet import Cell, Group, Row, Sheet
from hhrl_bench.tables.success import contestants, spans_tasks
from hhrl_bench.text import NONE

_SPECIAL = re.compile(r"([\\`*_\[\]<>|&~$@#]|:(?=//)|(?<=www)\.)", re.IGNORECASE)


class Scored(NamedTuple):
    """A result, and the name of the entry that it is from."""

    entry: str
    result: ResultRecord


def markdown(boards: Mapping[str, LeaderboardRecord]) -> str:
    """Return a page with the tables of leaderboards by the names of their entries, all of one suite.

    Rows of all entries stand in one table a task, the most successful first; only what was played in equal worlds is
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


def plain(text: str) -> str:
    """Return Markdown that shows a text as it is, on one line, whatever it holds."""
    return _SPECIAL.sub(r"\\\1", " ".join(text.split()))


def _overview(tasks: Sequence[TaskRecord], boards: Mapping[str, LeaderboardRecord]) -> Iterator[str]:
    """Yield the blocks of what agents do across tasks, if any does several."""
    if any(map(spans_tasks, boards.values())):
        entries = [name for name, board in boards.items() for _ in contestants(board)]
        yield from _sheet(_marked(success_module.overview_sheet(tasks, list(boards.values())), entries), "##")


def _task(task: TaskRecord, boards: Mapping[str, LeaderboardRecord]) -> Iterator[str]:
    """Yield the blocks of one task."""
    scored = [Scored(name, one) for name, board in boards.items() if task in board.tasks for one in board.on(task)]
    scored.sort(key=lambda one: -success(one.result))
    results, entries = [one.result for one in scored], [one.entry for one in scored]
    last = task.test_start + task.episodes - 1
    yield f"## {plain(task.id)}"
    yield f"{task.episodes:,} test episodes, the worlds of seeds {task.test_start} to {last}."
    for sheet in (
        _bounded_success(results_module.results_sheet(task, results)),
        worst_cases.details_sheet(task, results),
    ):
        yield from _sheet(_marked(sheet, entries), "###")
    for name, board in boards.items():
        if task in board.tasks and (compared := compared_to_best(board, task)):
            yield from _sheet(comparisons.comparison_sheet(compared), "###", name)


def _learning(name: str, board: LeaderboardRecord) -> Iterator[str]:
    """Yield the blocks of what an entry says of learning."""
    if board.efficiency:
        yield from _sheet(efficiency.efficiency_sheet(board.efficiency), "##", name)
    if board.transfer:
        for sheet in transfers.transfer_sheets(board.transfer.rows):
            yield from _sheet(sheet, "##", name)


def _made(name: str, board: LeaderboardRecord) -> str:
    made = board.provenance
    commit = f"commit {made.git_commit}" if made.git_commit else "no commit"
    return f"- {plain(name)}: {plain(made.command)}, version {plain(made.package_version)}, {commit}"


def _marked(sheet: Sheet, entries: Sequence[str]) -> Sheet:
    """Return the sheet with the entry of every row of its first group."""
    first, *others = sheet.groups
    pairs = zip(first.rows, entries, strict=True)
    groups = [
        Group(first.name, tuple(Row(row.name, (*row.cells, Cell(entry))) for row, entry in pairs)),
        *(Group(group.name, tuple(Row(row.name, (*row.cells, Cell())) for row in group.rows)) for group in others),
    ]
    return sheet._replace(headings=(*sheet.headings, "entry"), groups=tuple(groups))


def _bounded_success(sheet: Sheet) -> Sheet:
    """Return the sheet with the intervals of success alone."""
    kept = [heading == "success" for heading in sheet.headings[1:]]

    def bounded(row: Row) -> Row:
        cells = zip(row.cells, kept, strict=True)
        return Row(row.name, tuple(cell if keep else Cell(cell.value) for cell, keep in cells))

    return sheet._replace(groups=tuple(Group(one.name, tuple(map(bounded, one.rows))) for one in sheet.groups))


def _sheet(sheet: Sheet, level: str, entry: str = "") -> Iterator[str]:
    """Yield heading, table and notes."""
    yield f"{level} {plain(sheet.title)}" + (f", {plain(entry)}" if entry else "")
    lines = [_line(sheet.headings), "|".join(["", "---", *["---:"] * (len(sheet.headings) - 1), ""])]
    for group in sheet.groups:
        if group.name:
            lines.append(f"| **{plain(group.name)}** |{' |' * (len(sheet.headings) - 1)}")
        lines += [_line([row.name, *map(_said, row.cells)]) for row in group.rows]
    yield "\n".join(lines)
    if sheet.notes:
        yield "\n".join(f"- {plain(note)}" for note in sheet.notes)


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(map(plain, cells))} |"


def _said(cell: Cell) -> str:
    return (cell.value or NONE) + (f" ({cell.bounds})" if cell.bounds else "")
