"""The columns of the transfer table: what stands under each heading for an arm."""

from collections.abc import Callable
from typing import NamedTuple

from hhrl_bench.cells import Cell
from hhrl_bench.transfer_metrics import THRESHOLD
from hhrl_bench.transfer_records import SeedsMetricRecord, TransferRecord


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
