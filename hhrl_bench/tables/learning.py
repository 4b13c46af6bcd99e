"""What learning took: how soon trainings succeed, and how their episodes ended from the start to the end."""

from collections.abc import Sequence
from itertools import groupby

import numpy as np

from hhrl_bench.evaluation.metrics import METRICS
from hhrl_bench.leaderboard.efficiency import EfficiencyRecord
from hhrl_bench.tables.table import Cell, Column, Group, Note, Row, Table, TerminalFit, by_importance
from hhrl_bench.training.learning_curves import TRAINING_OUTCOMES, SharesRecord, TrainingOutcomesRecord

EFFICIENCY_NOTES = (
    Note("Env steps in thousands until validation succeeds that often; never: not within the budget."),
    Note("The median is over the seeds, those that never get there beyond the budget; its 95% interval a bootstrap."),
)
_EFFICIENCY = ("median", "95% interval", "seeds\nthere", "slowest\nseed", "budget")


def efficiency_table(records: Sequence[EfficiencyRecord]) -> Table:
    """Return how soon every training reaches the threshold, task by task."""
    groups = [
        Group(task, tuple(Row(one.method, _efficiency(one)) for one in own))
        for task, own in groupby(sorted(records, key=_task), key=_task)
    ]
    return Table(
        f"Thousand env steps to {records[0].threshold:.0%} validation success",
        "method",
        tuple(Column(heading, -i) for i, heading in enumerate(_EFFICIENCY)),
        tuple(groups),
        EFFICIENCY_NOTES,
        terminal_names="task",
        fit=TerminalFit(intervals=None),
    )


def _task(record: EfficiencyRecord) -> str:
    return record.task


def _efficiency(record: EfficiencyRecord) -> tuple[Cell, ...]:
    steps = record.steps
    bounds = "" if record.low is None else f"{_thousands(record.low)}, {_thousands(record.high)}"
    slowest = f"{_thousands(record.slowest)} ({record.slowest_seed})"
    there = f"{steps.reached} of {len(record.seeds)}"
    return tuple(map(Cell, (_thousands(steps.median), bounds, there, slowest, _thousands(record.budget))))


def _thousands(env_steps: float | None) -> str:
    return "never" if env_steps is None else f"{env_steps / 1000:.0f}"


OUTCOMES_TITLE = "How the episodes of trainings end"
OUTCOMES_NOTES = (
    Note("Means over the seeds; testing is greedy, on validation episodes."),
    Note("Start, middle and end: the first, middle and last report with such episodes."),
)
TIMES = ("start", "middle", "end")


def outcome_tables(trainings: Sequence[TrainingOutcomesRecord]) -> list[Table]:
    """Return how the episodes of every training ended at the start, in the middle and at the end, a table each."""
    return [_outcomes(training) for training in trainings]


def _outcomes(training: TrainingOutcomesRecord) -> Table:
    outcomes = by_importance(metric for key, metric in METRICS.items() if key in TRAINING_OUTCOMES)
    columns, cells = [], []
    for name, shares in (("training", training.training), ("testing", training.testing)):
        for i, outcome in enumerate(outcomes):
            columns.append(Column(f"{name}\n{outcome.heading}", -i))
            cells.append(_rates(shares, outcome.key))
    return Table(
        f"{training.method} on {training.task}, {training.runs}, {training.env_steps[-1]:,} env steps",
        "report",
        tuple(columns),
        (Group("", tuple(Row(time, own) for time, own in zip(TIMES, zip(*cells, strict=True), strict=True))),),
        OUTCOMES_NOTES,
        terminal_names="",
        fit=TerminalFit(intervals=None, wider=("", "more outcomes")),
    )


def _rates(shares: SharesRecord, outcome: str) -> list[Cell]:
    """Return the mean over seeds at the first, middle and last report at which a seed has episodes."""
    rates = shares.array(outcome)
    known = np.flatnonzero(np.isfinite(rates).any(axis=0))
    if not len(known):
        return [Cell()] * len(TIMES)
    times = known[[0, (len(known) - 1) // 2, -1]]
    return [Cell(f"{np.nanmean(rates[:, time]):.1%}") for time in times]
