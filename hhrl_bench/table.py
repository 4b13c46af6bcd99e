"""Results as a table to read: the nine columns of Table I with 95% intervals, the paper's own rows below."""

from collections.abc import Sequence
from typing import NamedTuple

from rich import box
from rich.console import Console, Group
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from hhrl_bench import paper
from hhrl_bench.cells import COLUMNS, NONE, Cell, Column, metric_cell, paper_cell, percent
from hhrl_bench.names import WIDTH, folded
from hhrl_bench.paper import CASES, TABLE_I
from hhrl_bench.records import ResultRecord, TaskRecord
from hhrl_bench.tasks import TASKS

BOUNDLESS = 1000


class Layout(NamedTuple):
    """What a table shows: these columns, with intervals or without, and names folded at so many characters."""

    columns: tuple[Column, ...]
    intervals: bool
    name_width: int


LAYOUTS = (
    Layout(COLUMNS, intervals=True, name_width=WIDTH),
    Layout(COLUMNS, intervals=False, name_width=WIDTH),
    *(Layout(COLUMNS[first:], intervals=False, name_width=12) for first in range(len(COLUMNS))),
)
"""From the widest to the narrowest, which has the agent and its success alone."""


def print_results(console: Console, task: TaskRecord, results: Sequence[ResultRecord]) -> None:
    """Return nothing; print one task's results in the widest layout that the console has room for."""
    print_widest(console, [results_table(task, results, layout) for layout in LAYOUTS])


def print_widest(console: Console, tables: Sequence[Table | Group], *, wrapped: bool = False) -> int:
    """Return the place of the table printed: the first that the console has room for; if none, the last.

    With ``wrapped`` there is room for one whose cells are wrapped between words.
    """
    boundless = console.options.update(max_width=BOUNDLESS)
    sizes = (Measurement.get(console, boundless, table) for table in tables)
    widths = (size.minimum if wrapped else size.maximum for size in sizes)
    place = next((place for place, width in enumerate(widths) if width <= console.width), len(tables) - 1)
    console.print(tables[place])
    return place


def ruled_table(title: str, *, intervals: bool) -> Table:
    """Return an empty table with rules between its parts alone; with ``intervals`` its columns stand further apart."""
    return Table(
        title=title,
        box=box.HORIZONTALS,
        show_edge=False,
        padding=(0, 1 if intervals else 0),
        collapse_padding=True,
        pad_edge=False,
        title_justify="left",
    )


def results_table(task: TaskRecord, results: Sequence[ResultRecord], layout: Layout) -> Table:
    """Return the table of one task's results, two lines an agent with intervals and one without."""
    columns, intervals, name_width = layout
    table = ruled_table(f"{task.id}, {task.episodes:,} test episodes", intervals=intervals)
    table.caption, table.caption_justify = _caption(task, results, layout), "left"
    table.add_column("agent", overflow="fold", max_width=name_width, vertical="top")
    for column in columns:
        table.add_column(
            column.heading if intervals else column.heading.replace(" ", "\n"), justify="right", no_wrap=True
        )
    for result in results:
        cells = (metric_cell(column, getattr(result.metrics, column.key)) for column in columns)
        table.add_row(_label(result, name_width), *(cell_text(cell, intervals=intervals) for cell in cells))
    if task.id in paper.TASKS:
        table.add_section()
        table.add_row(Text("the paper", style="italic"))
        for row in TABLE_I:
            cells = (paper_cell(column, row) for column in columns)
            table.add_row(row.policy, *(cell_text(cell, intervals=intervals) for cell in cells), style="dim")
    return table


def cell_text(cell: Cell, *, intervals: bool) -> Text:
    """Return a cell as text, its bounds on a line below where ``intervals`` are shown."""
    text = Text(cell.value or NONE)
    return text.append(f"\n{cell.bounds}", style="dim") if intervals and cell.bounds else text


def notes(task: TaskRecord, results: Sequence[ResultRecord], *, intervals: bool = True) -> list[str]:
    """Return what to know of the results of a task, a sentence or two a line."""
    lines = [_meaning(results) if intervals else "Means an episode."]
    if task.id in paper.TASKS:
        lines.append(f"The paper's rows: Table I, {CASES} cases" + (", Wilson." if intervals else "."))
    lines += [note for result in results if (note := _trained_elsewhere(task, result))]
    return lines + _traffic(task, results)


def _label(result: ResultRecord, width: int) -> Text:
    return Text(folded(result.agent, width)).append(f"\n{result.option} held" if result.option else "", style="dim")


def _caption(task: TaskRecord, results: Sequence[ResultRecord], layout: Layout) -> str:
    lines = notes(task, results, intervals=layout.intervals)
    if not layout.intervals:
        missing = " and more columns" if len(layout.columns) < len(COLUMNS) else ""
        lines.append(f"A wider terminal shows 95% intervals{missing}.")
    return "\n".join(lines)


def _meaning(results: Sequence[ResultRecord]) -> str:
    """Return what the numbers and their intervals are."""
    seeds = sorted({len(result.runs) for result in results if len(result.runs) > 1})
    notes = [f"over the {' or '.join(map(str, seeds))} training seeds"] if seeds else []
    if any(len(result.runs) == 1 for result in results):
        notes.append("over the episodes of a single policy (rates: Wilson)")
    return f"Means and 95% intervals: bootstrap {', or '.join(notes)}."


def _traffic(task: TaskRecord, results: Sequence[ResultRecord]) -> list[str]:
    """Return who drives the other vehicles, and each agent's success in the episodes that were feasible."""
    notes = ["One policy drives all vehicles; success: all of them stopped."] if task.shared else []
    known = TASKS.get(task.id)
    if task.opponent:
        notes.append(f"The front vehicle is driven by {task.opponent.agent}.")
    elif known and known.opponent:
        notes.append("The front vehicle is scripted.")
    shares = [(result.agent, result.traffic) for result in results if result.traffic]
    return notes + [
        f"{agent}: {percent(traffic.feasible)} of the episodes feasible, success there "
        f"{percent(traffic.success_feasible)}."
        for agent, traffic in shares
    ]


def _trained_elsewhere(task: TaskRecord, result: ResultRecord) -> str | None:
    """Return the note that an agent was trained in other scenarios than the task's; None if it was not."""
    others = {run.training.scenario for run in result.runs if run.training} - {task.scenario}
    return f"{result.agent} was trained in {', '.join(sorted(others))}." if others else None
