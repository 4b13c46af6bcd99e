"""How often agents succeed, task by task, as one row an agent."""

from collections.abc import Mapping, Sequence

from hhrl_bench.evaluation.metrics import METRICS
from hhrl_bench.evaluation.records import ResultRecord, TaskRecord
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.tables.table import Cell, Column, Group, Note, Row, Table, TerminalFit, metric_cell
from hhrl_bench.tasks.seeds import format_seeds
from hhrl_bench.text import folded

INTERVALS = Note("95% intervals: bootstrap over training seeds; Wilson for a single policy.", without_intervals="")
_FIT = TerminalFit("first", name_widths=(12,), wider=("95% intervals", "95% intervals and more tasks"))


def held(result: ResultRecord) -> str:
    """Return which option is held in a result; nothing where the agent chooses it."""
    return f"{result.option} held" if result.option else ""


def row_name(result: ResultRecord) -> str:
    """Return what a result is called in a row: its agent, and the option that is held."""
    return Row(result.agent, (), held(result)).full_name


def results_by_row(board: LeaderboardRecord) -> Mapping[str, Mapping[str, ResultRecord]]:
    """Return the results by task of every row, by its name."""
    names = dict.fromkeys(map(row_name, board.results))
    return {name: {one.task: one for one in board.results if row_name(one) == name} for name in names}


def spans_tasks(board: LeaderboardRecord) -> bool:
    """Return whether there is something to put side by side: an agent with results on several tasks."""
    return any(len(own) > 1 for own in results_by_row(board).values())


def success_table(tasks: Sequence[TaskRecord], boards: Sequence[LeaderboardRecord]) -> Table:
    """Return how often every agent of every leaderboard succeeds on each of its tasks."""
    rows = tuple(
        Row(name, tuple(success_cell(own.get(task.id) if task in board.tasks else None) for task in tasks))
        for board in boards
        for name, own in results_by_row(board).items()
    )
    episodes = " or ".join(dict.fromkeys(f"{task.episodes:,}" for task in tasks))
    return Table(
        "Success on every task",
        "agent",
        tuple(Column(task.id, -i, folded(task.id, 12), folded(task.id, 9)) for i, task in enumerate(tasks)),
        (Group("", rows),),
        _notes(tasks, boards),
        full_title=f"Success, {episodes} test episodes a task",
        fit=_FIT,
    )


def success_cell(result: ResultRecord | None) -> Cell:
    """Return how often an agent succeeds on a task: in which share of all episodes, as wherever success is told."""
    return Cell() if result is None else metric_cell(METRICS["success"], result.metrics.success)


def _notes(tasks: Sequence[TaskRecord], boards: Sequence[LeaderboardRecord]) -> tuple[Note, ...]:
    """Return what to know of successes side by side, the first line about intervals."""
    scored = [[one for board in boards if task in board.tasks for one in board.on(task)] for task in tasks]
    behind = [
        Note(_behind(task, task.opponent.agent, scored[place]), column=place)
        for place, task in enumerate(tasks)
        if task.opponent
    ]
    failed = [Note(_failed(one), column=place) for place, own in enumerate(scored) for one in own if one.failed_seeds]
    return (INTERVALS, *behind, *failed)


def _behind(task: TaskRecord, opponent: str, results: Sequence[ResultRecord]) -> str:
    shares = sorted(one.traffic.feasible.mean or 0.0 for one in results if one.traffic)
    share = " to ".join(dict.fromkeys(f"{one:.1%}" for one in (shares[0], shares[-1]))) if shares else "none"
    return f"{task.id}: behind {opponent}; {share} of the episodes were feasible."


def _failed(result: ResultRecord) -> str:
    seeds = f"seed{'s'[: len(result.failed_seeds) - 1]} {format_seeds(result.failed_seeds)}"
    return f"{row_name(result)} on {result.task}: without {seeds}, whose training failed."
