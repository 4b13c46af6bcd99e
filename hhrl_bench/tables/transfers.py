"""The columns of the transfer table: what stands under each heading for an arm."""

from collections.abc import Callable, Sequence
from itertools import groupby
from typing import NamedTuple

from rich.console import Console
from rich.console import Group as Stack
from rich.table import Table
from rich.text import Text

from hhrl_bench.tables.sheet import Cell, Group, Row, Sheet, _line
from hhrl_bench.tables.terminal import cell_text, print_widest, ruled_table
from hhrl_bench.tasks.seeds import format_seeds
from hhrl_bench.text import WIDTH, folded, indented
from hhrl_bench.training.learning_curves import THRESHOLD
from hhrl_bench.transfer.records import SeedsMetricRecord, TransferRecord


class Column(NamedTuple):
    """A heading, and what stands under it for an arm."""

    heading: str
    cell: Callable[[TransferRecord], Cell]


def _rate(metric: SeedsMetricRecord) -> Cell:
    bounds = None if metric.low is None or metric.high is None else f"{_percent(metric.low)}, {_percent(metric.high)}"
    return Cell(None if metric.mean is None else f"{metric.mean:.1%}", bounds)


def _percent(rate: float) -> str:
    return f"{100 * rate:.1f}" if rate < 0.9995 else "100"


def _gain(name: str) -> Callable[[TransferRecord], Cell]:
    def cell(row: TransferRecord) -> Cell:
        if row.over_scratch is None:
            return Cell()
        metric: SeedsMetricRecord = getattr(row.over_scratch, name)
        if metric.mean is None:
            return Cell()
        count = f" ({metric.n} of {len(row.seeds)})" if metric.n < len(row.seeds) else ""
        bounds = None if metric.low is None or metric.high is None else f"{metric.low:z.2f}, {metric.high:z.2f}"
        return Cell(f"{metric.mean:+z.2f}{count}", bounds)

    return cell


def _steps(row: TransferRecord) -> Cell:
    steps, seeds = row.steps_to_threshold, len(row.seeds)
    if not steps.reached:
        return Cell("never")
    count = f"{steps.reached} of {seeds}"
    if steps.median is None:
        return Cell(count)
    median = f"{steps.median / 1000:.0f}"
    return Cell(median if steps.reached == seeds else f"{median} ({count})")


def _steps_ratio(row: TransferRecord) -> Cell:
    if row.over_scratch is None:
        return Cell()
    ratio = row.over_scratch.steps_ratio
    high = "inf" if ratio.high is None else f"{ratio.high:.2f}"
    bounds = None if ratio.low is None else f"{ratio.low:.2f}, {high}"
    if ratio.at_most is not None:
        return Cell(f"{'' if ratio.at_least == ratio.at_most else '<= '}{ratio.at_most:.2f}", bounds)
    return Cell(f">= {ratio.at_least:.2f}", bounds) if ratio.at_least > 0.0 else Cell()


COLUMNS = (
    Column("success\nat step 0", lambda row: _rate(row.start)),
    Column(f"k steps\nto {THRESHOLD:.0%}", _steps),
    Column("steps\nratio", _steps_ratio),
    Column("forward\ntransfer", _gain("forward_transfer")),
    Column("jump-\nstart", _gain("jumpstart")),
    Column("success\nat end", lambda row: _rate(row.final)),
    Column("gain\nat end", _gain("asymptotic_gain")),
    Column("transfer\nratio", _gain("transfer_ratio")),
)
"""The first ones are shown longest where there is little room."""


def transfer_sheets(records: Sequence[TransferRecord]) -> list[Sheet]:
    """Return a table a method and source: target by target what every arm is worth."""
    ordered = sorted(records, key=lambda row: row.group)
    return [_transfers(list(own)) for _, own in groupby(ordered, key=lambda row: row.group[:2])]


def _transfers(rows: Sequence[TransferRecord]) -> Sheet:
    seeds = " or ".join(dict.fromkeys(format_seeds(row.seeds) for row in rows))
    groups = [
        Group(target, tuple(Row(row.arm, tuple(column.cell(row) for column in COLUMNS)) for row in own))
        for target, own in groupby(rows, key=lambda row: row.target)
    ]
    return Sheet(
        f"{rows[0].method} trained on {rows[0].source}, seeds {seeds}",
        ("arm", *(_line(column.heading) for column in COLUMNS)),
        tuple(groups),
        tuple(notes(rows)),
    )


def print_transfers(console: Console, rows: Sequence[TransferRecord]) -> None:
    """Return nothing; print a table for every method and source, in the widest layout that the console has room for."""
    columns = [column for column in COLUMNS if any(column.cell(row).value for row in rows)]
    narrower = [_tables(rows, columns[:last], intervals=False) for last in range(len(columns), 0, -1)]
    place = print_widest(console, [_tables(rows, columns, intervals=True), *narrower])
    console.print("\n".join(notes(rows, intervals=place == 0)), style="dim", highlight=False)


def _tables(rows: Sequence[TransferRecord], columns: Sequence[Column], *, intervals: bool) -> Stack:
    ordered = sorted(rows, key=lambda row: row.group)
    groups = [list(group) for _, group in groupby(ordered, key=lambda row: row.group[:2])]
    tables = [_table(group, columns, intervals=intervals) for group in groups]
    return Stack(*(part for table in tables for part in (table, "")))


def _table(rows: Sequence[TransferRecord], columns: Sequence[Column], *, intervals: bool) -> Table:
    """Return the table of one method and source, with two lines an arm or one without intervals."""
    first, seeds = rows[0], dict.fromkeys(format_seeds(row.seeds) for row in rows)
    table = ruled_table(f"{first.method} trained on {first.source}, seeds {' or '.join(seeds)}", intervals=intervals)
    table.add_column("target", overflow="fold", max_width=WIDTH + 2, vertical="top")
    for column in columns:
        table.add_column(column.heading, justify="right", no_wrap=True)
    for target, arms in groupby(rows, key=lambda row: row.target):
        table.add_section()
        table.add_row(Text(folded(target), style="bold"))
        for row in arms:
            table.add_row(indented(row.arm), *(cell_text(column.cell(row), intervals=intervals) for column in columns))
    return table


def notes(rows: Sequence[TransferRecord], *, intervals: bool = True) -> list[str]:
    """Return what to know of the arms, a sentence or two a line."""
    budgets = sorted({row.budget for row in rows})
    words = " to ".join(f"{budget:,}" for budget in dict.fromkeys((budgets[0], budgets[-1])))
    shown = "The pair with a number is its 95% interval, a bootstrap over the seeds; inf: without bound."
    return [
        f"Success on validation episodes; a budget of {words} env steps.",
        "Steps: the median in thousands, or how many seeds got there within the budget.",
        "Steps ratio: of the medians, below 1 is faster than scratch; <= and >= where one lies beyond the budget.",
        "Forward transfer: what the mean success gains over scratch, as a share of what scratch leaves to gain.",
        "Jumpstart: the gain over scratch at step 0. Transfer ratio: that of the mean, as a share of scratch's.",
        shown if intervals else "A wider terminal shows more columns and 95% intervals.",
    ]
