"""The one model of a table: a builder for each table makes it, and terminal, Markdown and HTML show it."""

from collections.abc import Callable, Iterable, Sequence
from typing import Literal, NamedTuple

from hhrl_bench.evaluation.metrics import HEADLINE, Metric
from hhrl_bench.evaluation.records import MetricRecord
from hhrl_bench.text import NAME_WIDTH, NONE


class Cell(NamedTuple):
    """A number as text, and the bounds of its interval; None: there is none.

    ``no_width``: whether both bounds are the same number.
    """

    value: str | None = None
    bounds: str | None = None
    no_width: bool = False


class Column(NamedTuple):
    """What stands above cells.

    Attributes:
        heading: its text; a line end in it is one in a terminal, and none on a page.
        priority: where a terminal lacks room, the columns of the lowest priority are left out first.
        wide: the heading in a terminal that shows intervals, if it is broken in another way there.
        narrow: the heading in a terminal that does not, if it is broken in another way there.
    """

    heading: str
    priority: int = 0
    wide: str | None = None
    narrow: str | None = None

    @property
    def line(self) -> str:
        """The heading in one line."""
        return unbroken(self.heading)


class Row(NamedTuple):
    """A name, a cell under every column, and what else tells it from rows of the same name."""

    name: str
    cells: tuple[Cell, ...]
    note: str = ""

    @property
    def full_name(self) -> str:
        """The name and its note in one line."""
        return f"{self.name}, {self.note}" if self.note else self.name


class Group(NamedTuple):
    """Rows that belong together, under a name or none; ``quoted``: their numbers are not ours."""

    name: str
    rows: tuple[Row, ...]
    quoted: bool = False


class Note(NamedTuple):
    """What to know of a table.

    Attributes:
        text: a sentence or two.
        without_intervals: what is said in its place where no intervals are shown; None: the same.
        column: the place of the column that it is about; where that is not shown nothing is said. None: of no one.
    """

    text: str
    without_intervals: str | None = None
    column: int | None = None


NO_WIDTH = Note(
    "Equal bounds: all training seeds, or all episodes, came to one number. Few that agree are no certainty.",
    without_intervals="",
)
"""What to know of intervals without a width: a bootstrap finds nothing that varies."""


class TerminalFit(NamedTuple):
    """How a table becomes narrower in a terminal without room for all of it.

    Attributes:
        intervals: whether its intervals are left out before its columns, or after them; None: it has none.
        name_widths: letters of a line of the names where no intervals are shown, to be tried in this order; fewer
            columns come with the last one.
        wider: what a wider terminal shows: where intervals are left out alone, and where columns are.
    """

    intervals: Literal["first", "last"] | None = "last"
    name_widths: tuple[int, ...] = (NAME_WIDTH,)
    wider: tuple[str, str] = ("more", "more")


class Table(NamedTuple):
    """A table.

    Attributes:
        title: what it is, below the heading of its task.
        names: what stands above the names of the rows.
        columns: those behind the names.
        groups: its rows; each has a cell for every column.
        notes: what to know of it.
        full_title: what it is where no heading says its task, if that is more.
        terminal_names: what stands above the names in a terminal, if it is another word.
        fit: how it becomes narrower.
    """

    title: str
    names: str
    columns: tuple[Column, ...]
    groups: tuple[Group, ...]
    notes: tuple[Note, ...] = ()
    full_title: str | None = None
    terminal_names: str | None = None
    fit: TerminalFit = TerminalFit()

    @property
    def all_notes(self) -> tuple[Note, ...]:
        """The notes, and the one about intervals without a width if there is such an interval."""
        cells = (cell for group in self.groups for row in group.rows for cell in row.cells)
        return (*self.notes, NO_WIDTH) if any(cell.no_width for cell in cells) else self.notes


def joined(title: str, tables: Sequence[Table]) -> Table:
    """Return one table in place of several with the same columns and notes: each is a group, named by its title."""
    groups = (Group(table.title, group.rows) for table in tables for group in table.groups)
    return tables[0]._replace(title=title, groups=tuple(groups))


def unbroken(heading: str) -> str:
    """Return a heading in one line; a word that was broken at its hyphen is whole again."""
    return heading.replace("-\n", "").replace("\n", " ")


def by_importance(metrics: Iterable[Metric]) -> list[Metric]:
    """Return metrics, those first that narrow tables keep longest: score, success, other rates, what all have."""
    return sorted(metrics, key=lambda one: (one.key != HEADLINE, one.key != "success", not one.is_rate, one.nullable))


def metric_text(metric: Metric, value: float, sign: Literal["", "+"] = "") -> str:
    """Return a value of a metric with its digits, rates in percent but without a sign of it."""
    return f"{value * (100.0 if metric.is_rate else 1.0):{sign}{'z' if sign else ''}.{metric.digits}f}"


def metric_cell(metric: Metric, record: MetricRecord | None) -> Cell:
    """Return a metric as it stands in its column; None: the result has no such metric."""
    return Cell() if record is None else number_cell(metric, record.mean, record.low, record.high)


def bounded_cell(value: str, low: float | None, high: float | None, shown: Callable[[float], str]) -> Cell:
    """Return a number as text, with the bounds of its interval as ``shown`` writes them if both are known."""
    if low is None or high is None:
        return Cell(value)
    return Cell(value, f"{shown(low)}, {shown(high)}", no_width=low == high)


def number_cell(metric: Metric, mean: float | None, low: float | None = None, high: float | None = None) -> Cell:
    """Return a mean with the bounds of its interval, rates in percent."""
    if mean is None:
        return Cell()
    scale = 100.0 if metric.is_rate else 1.0
    value = metric_text(metric, mean) + ("%" if metric.is_rate else "")
    return bounded_cell(value, low, high, lambda bound: _bound(bound * scale, metric.bound_digits))


def percent(metric: MetricRecord) -> str:
    """Return a rate in percent with its bounds."""
    if metric.mean is None:
        return NONE
    rate = f"{metric.mean:.1%}"
    return rate if metric.low is None or metric.high is None else f"{rate} ({metric.low:.1%}, {metric.high:.1%})"


def _bound(value: float, digits: int) -> str:
    """Return a bound with three significant digits, and at most ``digits`` after the point."""
    if abs(value) >= 99.95:
        return f"{value:.0f}"
    return f"{value:.1f}" if abs(value) >= 9.995 else f"{value:.{digits}f}"
