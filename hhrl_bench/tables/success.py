"""How often agents succeed, task by task, as one row an agent."""

from collections.abc import Mapping, Sequence

from hhrl_bench.evaluation.records import ResultRecord, TaskRecord
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.tables.sheet import COLUMNS, Cell, Group, Row, Sheet, metric_cell
from hhrl_bench.tasks.seeds import format_seeds

SUCCESS = next(column for column in COLUMNS if column.key == "success")
INTERVALS = "95% intervals: bootstrap over training seeds; Wilson for a single policy."


def contestant(result: ResultRecord) -> str:
    """Return who plays in a result: an agent, and the option that is held."""
    return f"{result.agent}, {result.option} held" if result.option else result.agent


def contestants(board: LeaderboardRecord) -> Mapping[str, Mapping[str, ResultRecord]]:
    """Return the results of every contestant by their tasks."""
    names = dict.fromkeys(map(contestant, board.results))
    return {name: {one.task: one for one in board.results if contestant(one) == name} for name in names}


def spans_tasks(board: LeaderboardRecord) -> bool:
    """Return whether there is something to put side by side: a contestant with results on several tasks."""
    return any(len(own) > 1 for own in contestants(board).values())


def success_cell(result: ResultRecord | None) -> Cell:
    """Return how often a contestant succeeds on a task, where vehicles learn in the episodes that stayed feasible."""
    if result is None:
        return Cell()
    return metric_cell(SUCCESS, result.traffic.success_feasible if result.traffic else result.metrics.success)


def notes(tasks: Sequence[TaskRecord], boards: Sequence[LeaderboardRecord]) -> tuple[str, ...]:
    """Return what to know of successes side by side, the first line about intervals."""
    scored = {task: [one for board in boards if task in board.tasks for one in board.on(task)] for task in tasks}
    behind = [_behind(task, task.opponent.agent, own) for task, own in scored.items() if task.opponent]
    failed = [_failed(one) for own in scored.values() for one in own if one.failed_seeds]
    return (INTERVALS, *behind, *failed)


def _behind(task: TaskRecord, opponent: str, results: Sequence[ResultRecord]) -> str:
    shares = sorted(one.traffic.feasible.mean or 0.0 for one in results if one.traffic)
    share = " to ".join(dict.fromkeys(f"{one:.1%}" for one in (shares[0], shares[-1]))) if shares else "none"
    return f"{task.id}: behind {opponent}, among the episodes that stayed feasible ({share})."


def _failed(result: ResultRecord) -> str:
    seeds = f"seed{'s'[: len(result.failed_seeds) - 1]} {format_seeds(result.failed_seeds)}"
    return f"{contestant(result)} on {result.task}: without {seeds}, whose training failed."


def overview_sheet(tasks: Sequence[TaskRecord], boards: Sequence[LeaderboardRecord]) -> Sheet:
    """Return how often every contestant of every leaderboard succeeds on each of its tasks."""
    rows = tuple(
        Row(name, tuple(success_cell(own.get(task.id) if task in board.tasks else None) for task in tasks))
        for board in boards
        for name, own in contestants(board).items()
    )
    headings = ("agent", *(task.id for task in tasks))
    return Sheet("Success on every task", headings, (Group("", rows),), notes(tasks, boards))
