"""Transfers: for every target, what each way of using a source policy is worth over training from scratch."""

from collections.abc import Callable, Sequence
from itertools import groupby
from typing import NamedTuple

from hhrl_bench.tables.table import Cell, Column, Group, Note, Row, Table, TerminalFit, bounded_cell
from hhrl_bench.tasks.seeds import format_seeds
from hhrl_bench.training.learning_curves import THRESHOLD
from hhrl_bench.transfer.records import SeedsMetricRecord, TransferRecord


class ArmColumn(NamedTuple):
    """A heading, and what stands under it for an arm."""

    heading: str
    cell: Callable[[TransferRecord], Cell]


def _rate(metric: SeedsMetricRecord) -> Cell:
    return Cell() if metric.mean is None else bounded_cell(f"{metric.mean:.1%}", metric.low, metric.high, _percent)


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
        return bounded_cell(f"{metric.mean:+z.2f}{count}", metric.low, metric.high, "{:z.2f}".format)

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


ARM_COLUMNS = (
    ArmColumn("success\nat step 0", lambda row: _rate(row.start)),
    ArmColumn(f"k steps\nto {THRESHOLD:.0%}", _steps),
    ArmColumn("steps\nratio", _steps_ratio),
    ArmColumn("forward\ntransfer", _gain("forward_transfer")),
    ArmColumn("jump-\nstart", _gain("jumpstart")),
    ArmColumn("success\nat end", lambda row: _rate(row.final)),
    ArmColumn("gain\nat end", _gain("asymptotic_gain")),
    ArmColumn("transfer\nratio", _gain("transfer_ratio")),
)
"""The first ones are shown longest where there is little room."""


def transfer_tables(records: Sequence[TransferRecord], *, known: bool = False) -> list[Table]:
    """Return a table a method and source: target by target what every arm is worth.

    known: whether columns are left out that have no number for any arm.
    """
    columns = [one for one in ARM_COLUMNS if not known or any(one.cell(row).value for row in records)]
    ordered = sorted(records, key=lambda row: row.group)
    return [_table(list(own), columns) for _, own in groupby(ordered, key=lambda row: row.group[:2])]


def _table(rows: Sequence[TransferRecord], columns: Sequence[ArmColumn]) -> Table:
    seeds = " or ".join(dict.fromkeys(format_seeds(row.seeds) for row in rows))
    groups = [
        Group(target, tuple(Row(row.arm, tuple(column.cell(row) for column in columns)) for row in own))
        for target, own in groupby(rows, key=lambda row: row.target)
    ]
    return Table(
        f"{rows[0].method} trained on {rows[0].source}, seeds {seeds}",
        "arm",
        tuple(Column(one.heading, -i) for i, one in enumerate(columns)),
        tuple(groups),
        _notes(rows),
        terminal_names="target",
        fit=TerminalFit("first", wider=("more columns and 95% intervals",) * 2),
    )


def _notes(rows: Sequence[TransferRecord]) -> tuple[Note, ...]:
    """Return what to know of the arms, a sentence or two a line."""
    budgets = sorted({row.budget for row in rows})
    words = " to ".join(f"{budget:,}" for budget in dict.fromkeys((budgets[0], budgets[-1])))
    return (
        Note(f"Success on validation episodes; a budget of {words} env steps."),
        Note("Steps: the median in thousands, or how many seeds got there within the budget."),
        Note(
            "Steps ratio: of the medians, below 1 is faster than scratch; <= and >= where one lies beyond the budget."
        ),
        Note("Forward transfer: what the mean success gains over scratch, as a share of what scratch leaves to gain."),
        Note("Jumpstart: the gain over scratch at step 0. Transfer ratio: that of the mean, as a share of scratch's."),
        Note("The pair with a number is its 95% interval, a bootstrap over the seeds; inf: without bound.", ""),
    )
