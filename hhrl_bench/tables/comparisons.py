"""Comparisons: agents a line, and how far each is from one and the same other agent."""

from collections.abc import Sequence
from itertools import groupby

from hhrl_bench.evaluation.metrics import METRICS, Metric
from hhrl_bench.leaderboard.comparisons import PairwiseRecord
from hhrl_bench.tables.table import Cell, Column, Group, Note, Row, Table, by_importance, metric_text

NOTES = (
    Note(
        "Differences of means; of rates, in percentage points. P: how likely a training seed's mean is higher than "
        "that of one of the other's, equal ones counted half; none between two agents without training seeds."
    ),
    Note(
        "The pair with a number is its 95% interval, a bootstrap over the training seeds; between two agents without "
        "any, over the test episodes, world by world.",
        without_intervals="",
    ),
)


def comparison_tables(comparisons: Sequence[PairwiseRecord]) -> list[Table]:
    """Return a table for each task and other agent, with every metric that some agents are compared by."""
    compared = {one.metric for one in comparisons}
    metrics = by_importance(metric for key, metric in METRICS.items() if key in compared)
    groups = groupby(sorted(comparisons, key=_group), key=_group)
    return [comparison_table(list(group), metrics) for _, group in groups]


def comparison_table(comparisons: Sequence[PairwiseRecord], metrics: Sequence[Metric]) -> Table:
    """Return how far agents are from the other one that all of them are compared to on a task, two columns a metric."""
    first, agents = comparisons[0], dict.fromkeys(one.agent for one in comparisons)
    known = {(one.agent, one.metric): one for one in comparisons}
    rows = (
        Row(agent, tuple(cell for metric in metrics for cell in _cells(metric, known.get((agent, metric.key)))))
        for agent in agents
    )
    compared = ", ".join(metric.heading for metric in metrics)
    return Table(
        f"{compared.capitalize()}, less that of {first.other}",
        "agent",
        tuple(column for i, metric in enumerate(metrics) for column in _columns(metric, -i)),
        (Group("", tuple(rows)),),
        NOTES,
        full_title=f"less {first.other} on {first.task}, {first.episodes:,} test episodes",
    )


def _group(one: PairwiseRecord) -> tuple[str, str]:
    return one.task, one.other


def _columns(metric: Metric, priority: int) -> tuple[Column, Column]:
    narrow = metric.heading.replace(" ", "\n")
    difference = "percentage points" if metric.is_rate else metric.heading
    return Column(difference, priority, wide=narrow, narrow=narrow), Column("P", priority)


def _cells(metric: Metric, one: PairwiseRecord | None) -> tuple[Cell, Cell]:
    """Return the difference, and the probability of having more."""
    if one is None or (mean := one.difference.mean) is None:
        return Cell(), Cell()
    difference, more = one.difference, one.probability_more
    bounds = None
    if difference.low is not None and difference.high is not None:
        bounds = f"{metric_text(metric, difference.low, '+')}, {metric_text(metric, difference.high, '+')}"
    probability = Cell(f"{more.mean:.2f}", f"{more.low:.2f}, {more.high:.2f}") if more else Cell()
    return Cell(metric_text(metric, mean, "+"), bounds), probability
