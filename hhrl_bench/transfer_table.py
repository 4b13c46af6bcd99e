"""Transfer as a table to read: for every method and source its targets, and an arm a line what it is worth there."""

from collections.abc import Sequence
from itertools import groupby

from rich.console import Console, Group
from rich.table import Table
from rich.text import Text

from hhrl_bench.names import WIDTH, folded, indented
from hhrl_bench.seeds import format_seeds
from hhrl_bench.table import cell_text, print_widest, ruled_table
from hhrl_bench.transfer_columns import COLUMNS, Column
from hhrl_bench.transfer_records import TransferRecord


def print_transfers(console: Console, rows: Sequence[TransferRecord]) -> None:
    """Return nothing; print a table for every method and source, in the widest layout that the console has room for."""
    columns = [column for column in COLUMNS if any(column.cell(row).value for row in rows)]
    narrower = [_tables(rows, columns[:last], intervals=False) for last in range(len(columns), 0, -1)]
    place = print_widest(console, [_tables(rows, columns, intervals=True), *narrower])
    console.print("\n".join(notes(rows, intervals=place == 0)), style="dim", highlight=False)


def _tables(rows: Sequence[TransferRecord], columns: Sequence[Column], *, intervals: bool) -> Group:
    ordered = sorted(rows, key=lambda row: row.group)
    groups = [list(group) for _, group in groupby(ordered, key=lambda row: row.group[:2])]
    tables = [_table(group, columns, intervals=intervals) for group in groups]
    return Group(*(part for table in tables for part in (table, "")))


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
