"""What a leaderboard says as plain tables, for pages: Markdown and HTML show the same ones."""

from collections.abc import Sequence
from itertools import groupby
from typing import NamedTuple

from hhrl_bench import details_table, efficiency_table, overview_table, paper, table, training_table, transfer_table
from hhrl_bench.cells import COLUMNS, Cell, mean_cell, metric_cell, paper_cell
from hhrl_bench.comparison_records import PairwiseRecord
from hhrl_bench.comparison_table import INTERVALS, MEANING, comparison_cells
from hhrl_bench.efficiency_records import EfficiencyRecord
from hhrl_bench.leaderboard_record import LeaderboardRecord
from hhrl_bench.overview_table import contestant, contestants, success_cell
from hhrl_bench.records import ResultRecord, RunRecord, TaskRecord
from hhrl_bench.seeds import format_seeds
from hhrl_bench.training_records import TrainingOutcomesRecord
from hhrl_bench.training_table import SHOWN, TIMES, rates
from hhrl_bench.transfer_columns import COLUMNS as TRANSFER_COLUMNS
from hhrl_bench.transfer_records import TransferRecord


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


def results_sheet(task: TaskRecord, results: Sequence[ResultRecord]) -> Sheet:
    """Return the nine columns of Table I, and below them the paper's rows where the task is one of its."""
    groups = [Group("", tuple(Row(contestant(result), (*_measured(result), _seeds(result))) for result in results))]
    if task.id in paper.TASKS:
        printed = (Row(row.policy, (*(paper_cell(column, row) for column in COLUMNS), Cell())) for row in paper.TABLE_I)
        groups.append(Group("the paper", tuple(printed)))
    headings = ("agent", *(column.heading for column in COLUMNS), "seeds")
    return Sheet("Results", headings, tuple(groups), tuple(table.notes(task, results)))


def overview_sheet(tasks: Sequence[TaskRecord], boards: Sequence[LeaderboardRecord]) -> Sheet:
    """Return how often every contestant of every leaderboard succeeds on each of its tasks."""
    rows = tuple(
        Row(name, tuple(success_cell(own.get(task.id) if task in board.tasks else None) for task in tasks))
        for board in boards
        for name, own in contestants(board).items()
    )
    headings = ("agent", *(task.id for task in tasks))
    return Sheet("Success on every task", headings, (Group("", rows),), overview_table.notes(tasks, boards))


def details_sheet(task: TaskRecord, results: Sequence[ResultRecord]) -> Sheet:
    """Return the worst training seed of every result, its collisions, and how severe its episodes are."""
    rows = tuple(Row(contestant(result), details_table.detail_cells(task, result)) for result in results)
    return Sheet("Worst cases", ("agent", *_lines(details_table.HEADINGS)), (Group("", rows),), details_table.NOTES)


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


def comparison_sheet(compared: Sequence[PairwiseRecord]) -> Sheet:
    """Return how far the success of every agent is from that of the agent that they are all compared to."""
    rows = tuple(Row(one.agent, comparison_cells(one)) for one in compared)
    title = f"Success, less that of {compared[0].other}"
    return Sheet(title, ("agent", "percentage points", "P"), (Group("", rows),), (MEANING, INTERVALS))


def efficiency_sheet(records: Sequence[EfficiencyRecord]) -> Sheet:
    """Return how soon every training reaches the threshold, task by task."""
    groups = [
        Group(task, tuple(Row(one.method, tuple(map(Cell, efficiency_table.efficiency_cells(one)))) for one in own))
        for task, own in groupby(sorted(records, key=lambda one: one.task), key=lambda one: one.task)
    ]
    title = f"Thousand env steps to {records[0].threshold:.0%} validation success"
    return Sheet(title, ("method", *_lines(efficiency_table.HEADINGS)), tuple(groups), efficiency_table.NOTES)


def transfer_sheets(records: Sequence[TransferRecord]) -> list[Sheet]:
    """Return a table a method and source: target by target what every arm is worth."""
    ordered = sorted(records, key=lambda row: row.group)
    return [_transfers(list(own)) for _, own in groupby(ordered, key=lambda row: row.group[:2])]


def trainings_sheet(records: Sequence[TrainingOutcomesRecord]) -> Sheet:
    """Return how the episodes of every training ended at the start, in the middle and at the end."""
    headings = (f"{part} {outcome.replace('_', ' ')}" for part in ("training", "testing") for outcome in SHOWN)
    groups = tuple(Group(training_table.title(record), _reports(record)) for record in records)
    return Sheet("How the episodes of trainings end", ("report", *headings), groups, training_table.NOTES)


def _measured(result: ResultRecord) -> list[Cell]:
    return [metric_cell(column, getattr(result.metrics, column.key)) for column in COLUMNS]


def _seeds(result: ResultRecord) -> Cell:
    failed = f", {len(result.failed_seeds)} failed" if result.failed_seeds else ""
    return Cell(f"{len(result.seeds)}{failed}" if result.seeds else None)


def _run(run: RunRecord) -> tuple[Cell, ...]:
    measured = [mean_cell(column, getattr(run.metrics, column.key)) for column in COLUMNS]
    steps = Cell(f"{run.training.env_steps:,}" if run.training else None)
    return (*measured, steps, Cell(run.checkpoint_sha256 and run.checkpoint_sha256[:12]))


def _transfers(rows: Sequence[TransferRecord]) -> Sheet:
    seeds = " or ".join(dict.fromkeys(format_seeds(row.seeds) for row in rows))
    groups = [
        Group(target, tuple(Row(row.arm, tuple(column.cell(row) for column in TRANSFER_COLUMNS)) for row in own))
        for target, own in groupby(rows, key=lambda row: row.target)
    ]
    return Sheet(
        f"{rows[0].method} trained on {rows[0].source}, seeds {seeds}",
        ("arm", *(_line(column.heading) for column in TRANSFER_COLUMNS)),
        tuple(groups),
        tuple(transfer_table.notes(rows)),
    )


def _reports(record: TrainingOutcomesRecord) -> tuple[Row, ...]:
    columns = [rates(shares, outcome) for shares in (record.training, record.testing) for outcome in SHOWN]
    return tuple(Row(time, tuple(Cell(column[i]) for column in columns)) for i, time in enumerate(TIMES))


def _line(heading: str) -> str:
    return heading.replace("-\n", "").replace("\n", " ")


def _lines(headings: Sequence[str]) -> tuple[str, ...]:
    return tuple(map(_line, headings))
