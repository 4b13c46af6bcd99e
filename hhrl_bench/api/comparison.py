"""``compare``: how far two agents are apart in the same worlds, with intervals."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from hhrl_bench.api.evaluate import AnyAgent, evaluate
from hhrl_bench.api.evaluation import Evaluation
from hhrl_bench.api.printed import Printed
from hhrl_bench.errors import AgentError, RecordError
from hhrl_bench.evaluation.metrics import METRICS, Metric
from hhrl_bench.exports.files import to_frame
from hhrl_bench.leaderboard.comparisons import PairwiseRecord, Runs, draws
from hhrl_bench.leaderboard.comparisons import compare as compared
from hhrl_bench.tables.comparisons import comparison_tables
from hhrl_bench.tables.table import Table
from hhrl_bench.tasks.tasks import AnyTask


class Comparison(Printed):
    """An agent minus another one, by every metric that both have in all episodes; it prints as a table.

    Between agents with training seeds, intervals are bootstraps over the seeds; between two single policies, over the
    test episodes, world by world.

    Attributes:
        records: the difference by each metric, with its interval, and the probability that a training seed has more.
    """

    def __init__(self, records: Sequence[PairwiseRecord]) -> None:
        self.records = tuple(records)

    def __getitem__(self, metric: str) -> PairwiseRecord:
        found = next((one for one in self.records if one.metric == metric), None)
        if found is None:
            known = ", ".join(one.metric for one in self.records)
            raise RecordError(f"the comparison has no metric {metric!r}; it has {known}")
        return found

    def tables(self) -> Sequence[Table]:
        """Return the table of differences."""
        return comparison_tables(self.records)

    def to_frame(self) -> Any:
        """Return a pandas ``DataFrame`` with a row for every metric; it needs the data extra."""
        first = {name: [getattr(one, name) for one in self.records] for name in ("agent", "other", "task", "metric")}
        ends = {name: [getattr(one.difference, name) for one in self.records] for name in ("mean", "low", "high")}
        more = [one.probability_more and one.probability_more.mean for one in self.records]
        return to_frame({**first, **ends, "probability_more": more})


def compare(
    a: AnyAgent | Evaluation,
    b: AnyAgent | Evaluation,
    task: AnyTask = "stop-line-v0",
    episodes: int = 1000,
) -> Comparison:
    """Return how far agent ``a`` is from agent ``b`` in the same test episodes, with 95% intervals.

    Args:
        a: an agent, as :func:`hhrl_bench.evaluate` takes it, or the evaluation of one.
        b: the agent that it is compared to.
        task: a task or its id, for agents that are not evaluated yet.
        episodes: how many test episodes, for agents that are not evaluated yet.

    Raises:
        InputError: in one line, as ``evaluate``; or if the evaluations are of several agents or of other worlds.
    """
    known = next((one for one in (a, b) if isinstance(one, Evaluation)), None)
    if known is not None:
        task, episodes = known.task, known.episodes
    first, second = (one if isinstance(one, Evaluation) else evaluate(one, task, episodes) for one in (a, b))
    if first.task_record != second.task_record:
        raise RecordError(
            f"{first.episodes} episodes of {first.task.id} and {second.episodes} of {second.task.id} are not the same "
            "worlds; evaluate both agents alike"
        )
    if first.result.agent == second.result.agent:
        raise AgentError(f"{first.result.agent} is compared to itself; name two agents, or give them names")
    return Comparison([_difference(first, second, metric) for metric in _of_both(first, second)])


def _of_both(first: Evaluation, second: Evaluation) -> list[Metric]:
    """Return the metrics that both agents have in every episode."""
    return [metric for metric in METRICS.values() if _has(first, metric) and _has(second, metric)]


def _has(evaluation: Evaluation, metric: Metric) -> bool:
    if metric.key not in evaluation.result.metrics:
        return False
    return not any(bool(np.isnan(values).any()) for values in _runs(evaluation, metric).values)


def _runs(evaluation: Evaluation, metric: Metric) -> Runs:
    return Runs(evaluation.result.agent, [metric.values(run.scored.records) for run in evaluation.runs])


def _difference(first: Evaluation, second: Evaluation, metric: Metric) -> PairwiseRecord:
    a, b, task = _runs(first, metric), _runs(second, metric), first.task.id
    return compared(a, b, task, metric.key, draws(a.agent, b.agent, task, metric.key))
