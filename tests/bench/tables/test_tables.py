"""The model of a table: how it becomes narrower, and that every renderer shows a metric that a user has registered."""

from collections.abc import Iterator
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from hhrl_bench.evaluation import metric
from hhrl_bench.evaluation.metrics import METRICS, Metric, register_metric
from hhrl_bench.evaluation.store import Store
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.publishing.html_page import html
from hhrl_bench.tables.markdown import markdown_table, suite_page
from hhrl_bench.tables.results import results_table
from hhrl_bench.tables.table import Cell, Column, Group, Note, Row, Table, TerminalFit, joined, number_cell
from hhrl_bench.tables.terminal import layouts, print_table
from support.pages import Page
from support.whole_board import whole_board

MISSES = Metric("line_misses", "line\nmisses", lambda ending: np.ones(len(ending.outcome)), "a user's own")


@pytest.fixture
def board() -> Iterator[LeaderboardRecord]:
    """A leaderboard that was scored before the user's metric was registered."""
    scored = whole_board()
    register_metric(MISSES)
    yield scored
    metric._by_key.pop(MISSES.key)


def with_metric(board: LeaderboardRecord) -> LeaderboardRecord:
    """Return the leaderboard with the user's metric in its first result."""
    first, *others = board.results
    own = first.metrics.unsafe.model_copy(update={"mean": 123.25})
    given = {**first.metrics.model_dump(), MISSES.key: own.model_dump()}
    more = first.model_copy(update={"metrics": type(first.metrics).model_validate(given)})
    return board.model_copy(update={"results": (more, *others)})


def table(fit: TerminalFit, *priorities: int) -> Table:
    cells = tuple(Cell("1", "0, 2") for _ in priorities)
    columns = tuple(Column(f"c{i}", priority) for i, priority in enumerate(priorities))
    notes = (Note("of intervals", ""), Note("of all"), Note("of the last", column=len(priorities) - 1))
    return Table("title", "name", columns, (Group("", (Row("a", cells),)),), notes, fit=fit)


def printed(shown: Table, width: int) -> str:
    console = Console(file=StringIO(), width=width)
    print_table(console, shown)
    assert isinstance(console.file, StringIO)
    return console.file.getvalue()


@pytest.mark.parametrize(
    ("fit", "known"),
    [
        (
            TerminalFit("first", (24, 12)),
            [("012", True, 24), ("012", False, 24), ("012", False, 12), ("02", False, 12)],
        ),
        (TerminalFit("last"), [("012", True, 24), ("02", True, 24), ("012", False, 24), ("02", False, 24)]),
        (TerminalFit(None), [("012", False, 24), ("02", False, 24)]),
    ],
)
def test_intervals_and_the_columns_of_the_lowest_priority_go_first(
    fit: TerminalFit, known: list[tuple[str, bool, int]]
) -> None:
    found = [("".join(map(str, one.columns)), one.intervals, one.name_width) for one in layouts(table(fit, 1, 0, 1))]
    assert found == known


def test_notes_are_of_what_is_shown_and_the_last_one_says_what_is_not() -> None:
    shown = table(TerminalFit("first", wider=("intervals", "columns")), 2, 1, 0)
    wide, bare, narrow = (" ".join(printed(shown, width).split()) for width in (80, 16, 8))
    assert wide.endswith("of intervals of all of the last")
    assert bare.endswith("of all of the last A wider terminal shows intervals.")
    assert narrow.replace(" ", "").endswith("ofallAwiderterminalshowscolumns.")


def test_an_interval_without_a_width_is_told_from_certainty() -> None:
    shown = table(TerminalFit("first"), 0)
    sure, rounded = (number_cell(METRICS["success"], 1.0, low, 1.0) for low in (1.0, 0.9999))
    assert (sure.bounds, rounded.bounds) == ("100, 100", "100, 100")
    for cell, said in ((sure, 1), (rounded, 0)):
        one = shown._replace(groups=(Group("", (Row("a", (cell,)),)),))
        for text in (printed(one, 80), "".join(markdown_table(one, "#"))):
            assert text.count("Equal bounds") == said
        assert "Equal bounds" not in printed(one, 12)


def test_joined_tables_are_groups_of_one() -> None:
    one = table(TerminalFit(), 0)
    whole = joined("both", [one, one._replace(title="other")])
    assert (whole.title, [group.name for group in whole.groups]) == ("both", ["title", "other"])


def test_a_registered_metric_is_the_last_column_wherever_results_are_shown(board: LeaderboardRecord) -> None:
    board = with_metric(board)
    task = board.tasks[0]
    shown = results_table(task, board.on(task))
    assert [column.line for column in shown.columns][-3:] == ["success", "score", "line misses"]
    assert [row.cells[-1].value for row in shown.groups[0].rows] == ["123.25", None, None]
    assert "123.25" in printed(shown, 200)
    narrow = printed(shown, 40)
    assert "score" in narrow
    assert "123.25" not in narrow
    assert "| success | score | line misses | seeds | entry |" in suite_page({"a": board})
    assert any("line misses" in row for row in Page(html(board, Store(Path("unused")))).rows)


def test_a_metric_that_no_result_has_is_no_column(board: LeaderboardRecord) -> None:
    assert results_table(board.tasks[0], board.on(board.tasks[0])).columns[-1].line == "score"


def test_a_table_says_which_rows_are_a_users_own_code(board: LeaderboardRecord) -> None:
    first, *others = board.on(board.tasks[0])
    own = first.model_copy(update={"agent": "mine:make", "kind": "factory"})
    notes = [note.text for note in results_table(board.tasks[0], [own, *others]).notes]
    said = [note for note in notes if "own code" in note]
    assert said == ["mine:make is a user's own code: to verify it, its decisions are replayed, not made again."]
