"""Comparisons: agents a line, and how far each is from one and the same other agent."""

from collections.abc import Iterator, Sequence
from itertools import groupby

from hhrl_bench.evaluation.metrics import METRICS, Metric
from hhrl_bench.leaderboard.comparisons import PairwiseRecord
from hhrl_bench.tables.table import Cell, Column, Group, Note, Row, Table, bounded_cell, by_importance, metric_text

_DIFFERENCES = Note("Differences of means; of rates, in percentage points.")
_PROBABILITY = Note(
    "P: how likely a training seed's mean is higher than that of one of the other's, equal ones counted half; none "
    "between two agents without training seeds."
)
_OVER = {
    "bootstrap-seeds": "over the training seeds",
    "bootstrap-episodes": "over the test episodes, world by world",
    "both": "over the training seeds; between two agents without any, over the test episodes, world by world",
}


def comparison_tables(comparisons: Sequence[PairwiseRecord]) -> list[Table]:
    """Return a table for each task and other agent, with every metric that some agents are compared by."""
    compared = {one.metric for one in comparisons}
    metrics = by_importance(metric for key, metric in METRICS.items() if key in compared)
    groups = groupby(sorted(comparisons, key=_group), key=_group)
    return [comparison_table(list(group), metrics) for _, group in groups]


def comparison_table(comparisons: Sequence[PairwiseRecord], metrics: Sequence[Metric]) -> Table:
    """Return how far agents are from the other one that all of them are compared to on a task.

    A metric has a column for the difference, and one for the probability of having more where some agents have that.
    """
    first, agents = comparisons[0], list(dict.fromkeys(one.agent for one in comparisons))
    known = {(one.agent, one.metric): one for one in comparisons}
    count = 2 if any(one.probability_more for one in comparisons) else 1
    rows = (
        Row(agent, tuple(cell for metric in metrics for cell in _cells(metric, known.get((agent, metric.key)))[:count]))
        for agent in agents
    )
    compared = ", ".join(metric.heading for metric in metrics)
    whose = agents[0] if len(agents) == 1 else "each agent"
    return Table(
        f"{compared.capitalize()}, less that of {first.other}",
        "agent",
        tuple(
            column
            for i, metric in enumerate(metrics)
            for column in _columns(metric, -i, alone=len(metrics) == 1)[:count]
        ),
        (Group("", tuple(rows)),),
        (_DIFFERENCES, *((_PROBABILITY,) if count > 1 else ()), *_intervals(comparisons)),
        full_title=f"{whose} minus {first.other} on {first.task}, {first.episodes:,} test episodes",
    )


def _intervals(comparisons: Sequence[PairwiseRecord]) -> Iterator[Note]:
    """Yield what the intervals are, if there are some."""
    kinds = {one.difference.interval for one in comparisons} & _OVER.keys()
    if kinds:
        over = _OVER[kinds.pop() if len(kinds) == 1 else "both"]
        yield Note(f"The pair with a number is its 95% interval, a bootstrap {over}.", without_intervals="")


def _group(one: PairwiseRecord) -> tuple[str, str]:
    return one.task, one.other


def _columns(metric: Metric, priority: int, *, alone: bool) -> tuple[Column, Column]:
    """Return the columns of a metric; what it is, the title says of one that is alone."""
    narrow = metric.heading.replace(" ", "\n")
    difference = "percentage points" if alone and metric.is_rate else metric.heading
    return Column(difference, priority, wide=narrow, narrow=narrow), Column("P", priority)


def _cells(metric: Metric, one: PairwiseRecord | None) -> tuple[Cell, Cell]:
    """Return the difference, and the probability of having more."""
    if one is None or (mean := one.difference.mean) is None:
        return Cell(), Cell()
    more, ends = one.probability_more, (one.difference.low, one.difference.high)
    probability = bounded_cell(f"{more.mean:.2f}", more.low, more.high, "{:.2f}".format) if more else Cell()
    return bounded_cell(
        metric_text(metric, mean, "+"), *ends, lambda bound: metric_text(metric, bound, "+")
    ), probability
