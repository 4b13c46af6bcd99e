"""Comparisons as a table to read: agents a line, and how far each is from one and the same other agent."""

from collections.abc import Sequence
from itertools import groupby

from rich.console import Console
from rich.console import Group as Stack
from rich.table import Table
from rich.text import Text

from hhrl_bench.leaderboard.comparisons import PairwiseRecord
from hhrl_bench.tables.sheet import COLUMNS, Cell, Column, Group, Row, Sheet
from hhrl_bench.tables.terminal import cell_text, print_widest, ruled_table
from hhrl_bench.text import WIDTH, folded

SHOWN = ("success", "collision", "not_stop", "timeout", "steps", "unsmooth", "unsafe", "return_option", "return_action")
"""The first ones are shown longest where there is little room."""

MEANING = (
    "Differences of means; of rates, in percentage points. P: how likely a training seed's mean is higher than that of "
    "one of the other's, equal ones counted half; none between two agents without training seeds."
)
INTERVALS = (
    "The pair with a number is its 95% interval, a bootstrap over the training seeds; between two agents without any, "
    "over the test episodes, world by world."
)
_BY_KEY = {column.key: column for column in COLUMNS}


def print_comparisons(console: Console, comparisons: Sequence[PairwiseRecord]) -> None:
    """Return nothing; print a table a task and other agent, in the widest layout that the console has room for.

    Metrics that are no column of Table I are left out.
    """
    metrics = [metric for metric in SHOWN if any(one.metric == metric for one in comparisons)]
    layouts = [(metrics[:last], intervals) for intervals in (True, False) for last in range(len(metrics), 0, -1)]
    place = print_widest(console, [_tables(comparisons, *layout) for layout in layouts])
    shown, intervals = layouts[place]
    console.print(_notes(intervals=intervals, all_shown=shown == metrics), style="dim", highlight=False)


def _tables(comparisons: Sequence[PairwiseRecord], metrics: Sequence[str], intervals: bool) -> Stack:
    groups = [list(group) for _, group in groupby(sorted(comparisons, key=_group), key=_group)]
    tables = [_table(group, metrics, intervals) for group in groups]
    return Stack(*(part for table in tables for part in (table, "")))


def _group(one: PairwiseRecord) -> tuple[str, str]:
    return one.task, one.other


def _table(comparisons: Sequence[PairwiseRecord], metrics: Sequence[str], intervals: bool) -> Table:
    """Return the table of one task and other agent, two lines an agent with intervals and one without."""
    first = comparisons[0]
    table = ruled_table(f"less {first.other} on {first.task}, {first.episodes:,} test episodes", intervals=intervals)
    table.add_column("agent", overflow="fold", max_width=WIDTH, vertical="top")
    for metric in metrics:
        table.add_column(_BY_KEY[metric].heading.replace(" ", "\n"), justify="right", no_wrap=True)
        table.add_column("P", justify="right", no_wrap=True)
    for agent in dict.fromkeys(one.agent for one in comparisons):
        own = {one.metric: one for one in comparisons if one.agent == agent}
        cells = (cell for metric in metrics for cell in comparison_cells(own.get(metric)))
        table.add_row(Text(folded(agent)), *(cell_text(cell, intervals=intervals) for cell in cells))
    return table


def comparison_cells(one: PairwiseRecord | None) -> tuple[Cell, Cell]:
    """Return the difference, and the probability of having more."""
    if one is None or (mean := one.difference.mean) is None:
        return Cell(), Cell()
    column, difference, more = _BY_KEY[one.metric], one.difference, one.probability_more
    bounds = None
    if difference.low is not None and difference.high is not None:
        bounds = f"{_signed(column, difference.low)}, {_signed(column, difference.high)}"
    probability = Cell(f"{more.mean:.2f}", f"{more.low:.2f}, {more.high:.2f}") if more else Cell()
    return Cell(_signed(column, mean), bounds), probability


def _signed(column: Column, value: float) -> str:
    return f"{value * (100.0 if column.percent else 1.0):+z.{column.digits}f}"


def _notes(*, intervals: bool, all_shown: bool) -> str:
    more = [] if intervals and all_shown else ["A wider terminal shows more."]
    return "\n".join([MEANING, *([INTERVALS] if intervals else []), *more])


def comparison_sheet(compared: Sequence[PairwiseRecord]) -> Sheet:
    """Return how far the success of every agent is from that of the agent that they are all compared to."""
    rows = tuple(Row(one.agent, comparison_cells(one)) for one in compared)
    title = f"Success, less that of {compared[0].other}"
    return Sheet(title, ("agent", "percentage points", "P"), (Group("", rows),), (MEANING, INTERVALS))
