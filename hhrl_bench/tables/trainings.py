"""Trainings as a table to read: how their episodes ended at the start, in the middle and at the end."""

from collections.abc import Sequence

import numpy as np
from rich.console import Console
from rich.console import Group as Stack
from rich.table import Table

from hhrl_bench.tables.sheet import Cell, Group, Row, Sheet
from hhrl_bench.tables.terminal import print_widest, ruled_table
from hhrl_bench.text import NONE
from hhrl_bench.training.learning_curves import SharesRecord, TrainingOutcomesRecord

SHOWN = ("success", "collision", "not_stop", "timeout")
"""The first ones are shown longest where there is little room."""

NOTES = (
    "Means over the seeds; testing is greedy, on validation episodes.",
    "Start, middle and end: the first, middle and last report with such episodes.",
)
TIMES = ("start", "middle", "end")


def print_trainings(console: Console, trainings: Sequence[TrainingOutcomesRecord]) -> None:
    """Return nothing; print a table a training, with as many outcomes as the console has room for."""
    layouts = [SHOWN[:last] for last in range(len(SHOWN), 0, -1)]
    place = print_widest(console, [_tables(trainings, outcomes) for outcomes in layouts])
    console.print("\n".join([*NOTES, *["A wider terminal shows more outcomes."][: place > 0]]), style="dim")


def title(training: TrainingOutcomesRecord) -> str:
    """Return what was trained, with which seeds, and for how long."""
    return f"{training.method} on {training.task}, {training.runs}, {training.env_steps[-1]:,} env steps"


def _tables(trainings: Sequence[TrainingOutcomesRecord], outcomes: Sequence[str]) -> Stack:
    return Stack(*(part for training in trainings for part in (_table(training, outcomes), "")))


def _table(training: TrainingOutcomesRecord, outcomes: Sequence[str]) -> Table:
    table = ruled_table(title(training), intervals=False)
    table.add_column("", no_wrap=True)
    columns = [list(TIMES)]
    for name in ("training", "testing"):
        shares: SharesRecord = getattr(training, name)
        for outcome in outcomes:
            table.add_column(f"{name}\n{outcome.replace('_', ' ')}", justify="right", no_wrap=True)
            columns.append(rates(shares, outcome))
    for cells in zip(*columns, strict=True):
        table.add_row(*cells)
    return table


def rates(shares: SharesRecord, outcome: str) -> list[str]:
    """Return the mean over seeds at the first, middle and last report at which a seed has episodes."""
    rates = shares.array(outcome)
    known = np.flatnonzero(np.isfinite(rates).any(axis=0))
    if not len(known):
        return [NONE] * len(TIMES)
    times = known[[0, (len(known) - 1) // 2, -1]]
    return [f"{np.nanmean(rates[:, time]):.1%}" for time in times]


def trainings_sheet(records: Sequence[TrainingOutcomesRecord]) -> Sheet:
    """Return how the episodes of every training ended at the start, in the middle and at the end."""
    headings = (f"{part} {outcome.replace('_', ' ')}" for part in ("training", "testing") for outcome in SHOWN)
    groups = tuple(Group(title(record), _reports(record)) for record in records)
    return Sheet("How the episodes of trainings end", ("report", *headings), groups, NOTES)


def _reports(record: TrainingOutcomesRecord) -> tuple[Row, ...]:
    columns = [rates(shares, outcome) for shares in (record.training, record.testing) for outcome in SHOWN]
    return tuple(Row(time, tuple(Cell(column[i]) for column in columns)) for i, time in enumerate(TIMES))
