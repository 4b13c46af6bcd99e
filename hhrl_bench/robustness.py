"""How agents do in ordinary traffic, among held-out drivers and behind an adversary, as one row an agent."""

from rich import box
from rich.console import Console
from rich.table import Table

from hhrl_bench.cells import percent
from hhrl_bench.leaderboard_record import LeaderboardRecord
from hhrl_bench.names import folded
from hhrl_bench.records import MetricRecord, ResultRecord


def print_robustness(console: Console, board: LeaderboardRecord) -> None:
    """Return nothing; print the success of every agent on every task of the board."""
    table = Table(box=box.HORIZONTALS, show_edge=False, pad_edge=False, title_justify="left", caption_justify="left")
    table.title = f"success, {board.tasks[0].episodes:,} test episodes a task"
    table.caption = _caption(board)
    table.add_column("agent", overflow="fold")
    for task in board.tasks:
        table.add_column(task.id, justify="right")
    table.add_column("feasible", justify="right")
    for agent in dict.fromkeys(result.agent for result in board.results):
        own = {result.task: result for result in board.results if result.agent == agent}
        results = [own[task.id] for task in board.tasks]
        feasible = [percent(result.traffic.feasible) for result in results if result.traffic]
        table.add_row(folded(agent), *(percent(_success(result)) for result in results), *feasible)
    console.print(table)


def _success(result: ResultRecord) -> MetricRecord:
    return result.traffic.success_feasible if result.traffic else result.metrics.success


def _caption(board: LeaderboardRecord) -> str:
    lines = ["95% intervals: bootstrap over training seeds; Wilson for a single policy."]
    behind = [(task.id, task.opponent.agent) for task in board.tasks if task.opponent]
    lines += [f"{task}: behind {agent}, among the episodes that stayed feasible." for task, agent in behind]
    return "\n".join(lines)
