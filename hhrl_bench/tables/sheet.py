"""What a leaderboard says as plain tables, for pages: Markdown and HTML show the same ones."""

from collections.abc import Sequence
from typing import NamedTuple

from hhrl_bench.evaluation.records import MetricRecord
from hhrl_bench.paper_table import CASES, PaperRow
from hhrl_bench.statistics.intervals import wilson
from hhrl_bench.text import NONE


class Cell(NamedTuple):
    """A number as text, and the bounds of its interval; None: there is none."""

    value: str | None = None
    bounds: str | None = None


class Row(NamedTuple):
    """A name, and a cell under every heading but the first."""

    name: str
    cells: tuple[Cell, ...]


class Group(NamedTuple):
    """Rows that belong together, under a name or none."""

    name: str
    rows: tuple[Row, ...]


class Sheet(NamedTuple):
    """A table: its headings, the first of which is that of the names, its rows, and what to know of it."""

    title: str
    headings: tuple[str, ...]
    groups: tuple[Group, ...]
    notes: tuple[str, ...] = ()


def _line(heading: str) -> str:
    return heading.replace("-\n", "").replace("\n", " ")


def _lines(headings: Sequence[str]) -> tuple[str, ...]:
    return tuple(map(_line, headings))


def percent(metric: MetricRecord) -> str:
    """Return a rate in percent with its bounds."""
    if metric.mean is None:
        return NONE
    rate = f"{metric.mean:.1%}"
    return rate if metric.low is None or metric.high is None else f"{rate} ({metric.low:.1%}, {metric.high:.1%})"


class Column(NamedTuple):
    """A column: metric key, heading, digits after the point of means and of bounds; rates in percent."""

    key: str
    heading: str
    digits: int
    bound_digits: int
    percent: bool = False


COLUMNS = (
    Column("return_option", "r^o", 2, 1),
    Column("return_action", "r^a", 2, 1),
    Column("steps", "step", 1, 1),
    Column("unsmooth", "unsmooth", 2, 2),
    Column("unsafe", "unsafe", 2, 2),
    Column("collision", "collision", 1, 1, percent=True),
    Column("not_stop", "not stop", 1, 1, percent=True),
    Column("timeout", "timeout", 1, 1, percent=True),
    Column("success", "success", 1, 1, percent=True),
)
"""Those of Table I."""


def metric_cell(column: Column, metric: MetricRecord) -> Cell:
    """Return a metric as it stands in a column."""
    return Cell() if metric.mean is None else _cell(column, metric.mean, metric.low, metric.high)


def mean_cell(column: Column, mean: float | None) -> Cell:
    """Return a mean as it stands in a column, without bounds."""
    return Cell() if mean is None else _cell(column, mean, None, None)


def paper_cell(column: Column, row: PaperRow) -> Cell:
    """Return a number of Table I with the digits that it is printed with; of rates with Wilson's interval."""
    value = getattr(row, column.key)
    printed = column._replace(digits=0) if isinstance(value, int) else column
    if not column.percent:
        return _cell(printed, value, None, None)
    estimate = wilson(value, CASES)
    return _cell(printed, estimate.mean, estimate.low, estimate.high)


def _cell(column: Column, mean: float, low: float | None, high: float | None) -> Cell:
    scale = 100.0 if column.percent else 1.0
    value = f"{mean * scale:.{column.digits}f}" + ("%" if column.percent else "")
    if low is None or high is None:
        return Cell(value)
    return Cell(value, ", ".join(_bound(bound * scale, column.bound_digits) for bound in (low, high)))


def _bound(value: float, digits: int) -> str:
    """Return a bound with three significant digits, and at most ``digits`` after the point."""
    if abs(value) >= 99.95:
        return f"{value:.0f}"
    return f"{value:.1f}" if abs(value) >= 9.995 else f"{value:.{digits}f}"
