"""Results as a table to read: the nine columns of Table I with 95% intervals, the paper's own rows below."""

from collections.abc import Sequence
from typing import NamedTuple

from rich.console import Console
from rich.table import Table
from rich.text import Text

from hhrl_bench import paper_table
from hhrl_bench.evaluation.records import ResultRecord, RunRecord, TaskRecord
from hhrl_bench.paper_table import CASES, TABLE_I
from hhrl_bench.tables.sheet import (
    COLUMNS,
    Cell,
    Column,
    Group,
    Row,
    Sheet,
    mean_cell,
    metric_cell,
    paper_cell,
    percent,
)
from hhrl_bench.tables.success import contestant
from hhrl_bench.tables.terminal import cell_text, print_widest, ruled_table
from hhrl_bench.tasks.tasks import TASKS
from hhrl_bench.text import WIDTH, folded


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
    if task.id in paper_table.TASKS:
        table.add_section()
        table.add_row(Text("the paper", style="italic"))
        for row in TABLE_I:
            cells = (paper_cell(column, row) for column in columns)
            table.add_row(row.policy, *(cell_text(cell, intervals=intervals) for cell in cells), style="dim")
    return table


def notes(task: TaskRecord, results: Sequence[ResultRecord], *, intervals: bool = True) -> list[str]:
    """Return what to know of the results of a task, a sentence or two a line."""
    lines = [_meaning(results) if intervals else "Means an episode."]
    if task.id in paper_table.TASKS:
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


def results_sheet(task: TaskRecord, results: Sequence[ResultRecord]) -> Sheet:
    """Return the nine columns of Table I, and below them the paper's rows where the task is one of its."""
    groups = [Group("", tuple(Row(contestant(result), (*_measured(result), _seeds(result))) for result in results))]
    if task.id in paper_table.TASKS:
        printed = (
            Row(row.policy, (*(paper_cell(column, row) for column in COLUMNS), Cell())) for row in paper_table.TABLE_I
        )
        groups.append(Group("the paper", tuple(printed)))
    headings = ("agent", *(column.heading for column in COLUMNS), "seeds")
    return Sheet("Results", headings, tuple(groups), tuple(notes(task, results)))


def runs_sheet(results: Sequence[ResultRecord]) -> Sheet:
    """Return every training seed of the results that have some, with the env steps that its checkpoint was trained."""
    groups = [
        Group(
            contestant(result),
            tuple(Row(f"seed {run.training.seed}", _run(run)) for run in result.runs if run.training),
        )
        for result in results
        if result.seeds
    ]
    headings = ("training seed", *(column.heading for column in COLUMNS), "env steps", "checkpoint sha256")
    return Sheet("Every training seed", headings, tuple(groups))


def _measured(result: ResultRecord) -> list[Cell]:
    return [metric_cell(column, getattr(result.metrics, column.key)) for column in COLUMNS]


def _seeds(result: ResultRecord) -> Cell:
    failed = f", {len(result.failed_seeds)} failed" if result.failed_seeds else ""
    return Cell(f"{len(result.seeds)}{failed}" if result.seeds else None)


def _run(run: RunRecord) -> tuple[Cell, ...]:
    measured = [mean_cell(column, getattr(run.metrics, column.key)) for column in COLUMNS]
    steps = Cell(f"{run.training.env_steps:,}" if run.training else None)
    return (*measured, steps, Cell(run.checkpoint_sha256 and run.checkpoint_sha256[:12]))
