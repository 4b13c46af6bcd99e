"""Sample efficiency as a table to read: for every task, a method a line and how soon it reaches the threshold."""

from collections.abc import Sequence
from itertools import groupby

from rich.console import Console
from rich.table import Table
from rich.text import Text

from hhrl_bench.leaderboard.efficiency import EfficiencyRecord
from hhrl_bench.tables.sheet import Cell, Group, Row, Sheet, _lines
from hhrl_bench.tables.terminal import print_widest, ruled_table
from hhrl_bench.text import WIDTH, folded, indented

NOTES = (
    "Env steps in thousands until validation succeeds that often; never: not within the budget.",
    "The median is over the seeds, those that never get there beyond the budget; its 95% interval a bootstrap.",
)
HEADINGS = ("median", "95% interval", "seeds\nthere", "slowest\nseed", "budget")
"""The first ones are shown longest where there is little room."""


def print_efficiencies(console: Console, records: Sequence[EfficiencyRecord]) -> None:
    """Return nothing; print one table of all tasks, with as many columns as the console has room for."""
    place = print_widest(console, [_table(records, last) for last in range(len(HEADINGS), 0, -1)])
    console.print("\n".join([*NOTES, *["A wider terminal shows more."][: place > 0]]), style="dim", highlight=False)


def _table(records: Sequence[EfficiencyRecord], columns: int) -> Table:
    table = ruled_table(f"Thousand env steps to {records[0].threshold:.0%} validation success", intervals=False)
    table.add_column("task", overflow="fold", max_width=WIDTH + 2, vertical="top")
    for heading in HEADINGS[:columns]:
        table.add_column(heading, justify="right", no_wrap=True)
    for task, group in groupby(sorted(records, key=_task), key=_task):
        table.add_section()
        table.add_row(Text(folded(task), style="bold"))
        for record in group:
            table.add_row(indented(record.method), *efficiency_cells(record)[:columns])
    return table


def _task(record: EfficiencyRecord) -> str:
    return record.task


def efficiency_cells(record: EfficiencyRecord) -> tuple[str, ...]:
    """Return what stands under HEADINGS for a record."""
    steps = record.steps
    bounds = "" if record.low is None else f"{_thousands(record.low)}, {_thousands(record.high)}"
    slowest = f"{_thousands(record.slowest)} ({record.slowest_seed})"
    there = f"{steps.reached} of {len(record.seeds)}"
    return _thousands(steps.median), bounds, there, slowest, _thousands(record.budget)


def _thousands(env_steps: float | None) -> str:
    return "never" if env_steps is None else f"{env_steps / 1000:.0f}"


def efficiency_sheet(records: Sequence[EfficiencyRecord]) -> Sheet:
    """Return how soon every training reaches the threshold, task by task."""
    groups = [
        Group(task, tuple(Row(one.method, tuple(map(Cell, efficiency_cells(one)))) for one in own))
        for task, own in groupby(sorted(records, key=lambda one: one.task), key=lambda one: one.task)
    ]
    title = f"Thousand env steps to {records[0].threshold:.0%} validation success"
    return Sheet(title, ("method", *_lines(HEADINGS)), tuple(groups), NOTES)
