"""The reference of a task: the agent that succeeds most often, to which every other one is compared."""

from hhrl_bench.comparison_records import PairwiseRecord
from hhrl_bench.comparisons import against
from hhrl_bench.leaderboard_record import LeaderboardRecord
from hhrl_bench.records import ResultRecord, TaskRecord


def success(result: ResultRecord) -> float:
    """Return how often a result succeeds, from 0 to 1."""
    return result.metrics.success.mean or 0.0


def compared_to_best(board: LeaderboardRecord, task: TaskRecord) -> list[PairwiseRecord]:
    """Return the comparison of every other agent to the most successful one of a task, in the order of the results."""
    results = board.on(task)
    if not results:
        return []
    return against(max(results, key=success).agent, [one for one in board.comparisons if one.task == task.id])
