"""Results as a table to read: the nine columns of Table I with 95% intervals, the paper's own rows below."""

from collections.abc import Sequence
from typing import NamedTuple

from rich import box
from rich.console import Console, Group
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from hhrl_bench import paper
from hhrl_bench.paper import CASES, TABLE_I, PaperRow
from hhrl_bench.records import MetricRecord, ResultRecord, TaskRecord
from hhrl_bench.statistics import wilson

BOUNDLESS = 1000
NONE = "\N{EN DASH}"


class Column(NamedTuple):
    """A column of Table I: metric key, heading, digits after the point of means and of bounds; rates in percent."""

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


class Layout(NamedTuple):
    """What a table shows: these columns, with intervals or without, and names folded at so many characters."""

    columns: tuple[Column, ...]
    intervals: bool
    name_width: int


LAYOUTS = (
    Layout(COLUMNS, intervals=True, name_width=24),
    Layout(COLUMNS, intervals=False, name_width=24),
    *(Layout(COLUMNS[first:], intervals=False, name_width=12) for first in range(len(COLUMNS))),
)
"""From the widest to the narrowest, which has the agent and its success alone."""


def print_results(console: Console, task: TaskRecord, results: Sequence[ResultRecord]) -> None:
    """Return nothing; print one task's results in the widest layout that the console has room for."""
    print_widest(console, [results_table(task, results, layout) for layout in LAYOUTS])


def print_widest(console: Console, tables: Sequence[Table | Group]) -> int:
    """Return the place of the table printed: the first that the console has room for; if none, the last."""
    boundless = console.options.update(max_width=BOUNDLESS)
    widths = (Measurement.get(console, boundless, table).maximum for table in tables)
    place = next((place for place, width in enumerate(widths) if width <= console.width), len(tables) - 1)
    console.print(tables[place])
    return place


def results_table(task: TaskRecord, results: Sequence[ResultRecord], layout: Layout) -> Table:
    """Return the table of one task's results, two lines an agent with intervals and one without."""
    columns, intervals, name_width = layout
    table = Table(
        title=f"{task.id}, {task.episodes:,} test episodes",
        caption=_caption(task, results, layout),
        box=box.HORIZONTALS,
        show_edge=False,
        padding=(0, 1 if intervals else 0),
        collapse_padding=True,
        pad_edge=False,
        title_justify="left",
        caption_justify="left",
    )
    table.add_column("agent", overflow="fold", max_width=name_width, vertical="top")
    for column in columns:
        table.add_column(
            column.heading if intervals else column.heading.replace(" ", "\n"), justify="right", no_wrap=True
        )
    for result in results:
        table.add_row(_label(result), *(_cell(column, result, intervals=intervals) for column in columns))
    if task.id in paper.TASKS:
        table.add_section()
        table.add_row(Text("the paper", style="italic"))
        for row in TABLE_I:
            cells = (_paper_cell(column, row, intervals=intervals) for column in columns)
            table.add_row(row.policy, *cells, style="dim")
    return table


def _label(result: ResultRecord) -> Text:
    return Text(result.agent).append(f"\n{result.option} held" if result.option else "", style="dim")


def _cell(column: Column, result: ResultRecord, *, intervals: bool) -> Text:
    metric: MetricRecord = getattr(result.metrics, column.key)
    if metric.mean is None:
        return Text(NONE)
    return _text(column, metric.mean, metric.low, metric.high, intervals=intervals)


def _paper_cell(column: Column, row: PaperRow, *, intervals: bool) -> Text:
    value = getattr(row, column.key)
    printed = column._replace(digits=0) if isinstance(value, int) else column
    if not column.percent:
        return _text(printed, value, None, None, intervals=intervals)
    estimate = wilson(value, CASES)
    return _text(printed, estimate.mean, estimate.low, estimate.high, intervals=intervals)


def _text(column: Column, mean: float, low: float | None, high: float | None, *, intervals: bool) -> Text:
    scale = 100.0 if column.percent else 1.0
    text = Text(f"{mean * scale:.{column.digits}f}" + ("%" if column.percent else ""))
    if intervals and low is not None and high is not None:
        bounds = (_bound(bound * scale, column.bound_digits) for bound in (low, high))
        text.append("\n" + ", ".join(bounds), style="dim")
    return text


def _bound(value: float, digits: int) -> str:
    """Return a bound with three significant digits, and at most ``digits`` after the point."""
    if abs(value) >= 99.95:
        return f"{value:.0f}"
    return f"{value:.1f}" if abs(value) >= 9.995 else f"{value:.{digits}f}"


def _caption(task: TaskRecord, results: Sequence[ResultRecord], layout: Layout) -> str:
    lines = [_meaning(results) if layout.intervals else "Means an episode."]
    if task.id in paper.TASKS:
        lines.append(f"The paper's rows: Table I, {CASES} cases" + (", Wilson." if layout.intervals else "."))
    lines += [note for result in results if (note := _trained_elsewhere(task, result))]
    lines += _traffic(task, results)
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
    notes += [f"The front vehicle is driven by {task.opponent.agent}."] if task.opponent else []
    shares = [(result.agent, result.traffic) for result in results if result.traffic]
    return notes + [
        f"{agent}: {percent(traffic.feasible)} of the episodes feasible, success there "
        f"{percent(traffic.success_feasible)}."
        for agent, traffic in shares
    ]


def percent(metric: MetricRecord) -> str:
    """Return a rate in percent with its bounds."""
    if metric.mean is None:
        return NONE
    rate = f"{metric.mean:.1%}"
    return rate if metric.low is None or metric.high is None else f"{rate} ({metric.low:.1%}, {metric.high:.1%})"


def _trained_elsewhere(task: TaskRecord, result: ResultRecord) -> str | None:
    """Return the note that an agent was trained in other scenarios than the task's; None if it was not."""
    others = {run.training.scenario for run in result.runs if run.training} - {task.scenario}
    return f"{result.agent} was trained in {', '.join(sorted(others))}." if others else None
