"""Every agent of a task compared to one and the same reference: the agent that succeeds most often."""

from collections.abc import Sequence

from hhrl_bench.comparison_records import DifferenceRecord, PairwiseRecord, ProbabilityRecord
from hhrl_bench.leaderboard_record import LeaderboardRecord
from hhrl_bench.records import ResultRecord, TaskRecord


def by_success(results: Sequence[ResultRecord]) -> list[ResultRecord]:
    """Return the results, the most successful first; equal ones keep their order."""
    return sorted(results, key=lambda result: -(result.metrics.success.mean or 0.0))


def compared_to_best(board: LeaderboardRecord, task: TaskRecord) -> list[PairwiseRecord]:
    """Return the comparison of every other agent to the most successful one of a task, in the order of the results."""
    best = {result.agent for result in by_success(board.on(task))[:1]}
    pairs = [one for one in board.comparisons if one.task == task.id and best & {one.agent, one.other}]
    return [one if one.other in best else _turned(one) for one in pairs]


def _turned(one: PairwiseRecord) -> PairwiseRecord:
    """Return the comparison of the other agent to the agent."""
    more = one.probability_more
    return PairwiseRecord(
        agent=one.other,
        other=one.agent,
        task=one.task,
        metric=one.metric,
        runs=one.other_runs,
        other_runs=one.runs,
        episodes=one.episodes,
        difference=_negated(one.difference),
        probability_more=more and ProbabilityRecord(mean=1.0 - more.mean, low=1.0 - more.high, high=1.0 - more.low),
    )


def _negated(one: DifferenceRecord) -> DifferenceRecord:
    mean, low, high = (None if number is None else -number for number in (one.mean, one.high, one.low))
    return DifferenceRecord(mean=mean, low=low, high=high, interval=one.interval)
