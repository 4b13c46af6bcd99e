"""A leaderboard as tables to read."""

from rich.console import Console

from hhrl_bench.leaderboard.record import LeaderboardRecord, compared_to_best
from hhrl_bench.tables.comparisons import print_comparisons
from hhrl_bench.tables.efficiency import print_efficiencies
from hhrl_bench.tables.results import print_results
from hhrl_bench.tables.success import spans_tasks
from hhrl_bench.tables.terminal import print_overview
from hhrl_bench.tables.trainings import print_trainings
from hhrl_bench.tables.transfers import print_transfers
from hhrl_bench.tables.worst_cases import print_details


def print_leaderboard(console: Console, board: LeaderboardRecord, *, details: bool = False) -> None:
    """Return nothing; print the results of every task, what agents do across tasks, transfers and trainings.

    With ``details`` also the worst cases, how far every agent is from the best, and how soon methods succeed.
    """
    for task in board.tasks:
        print_results(console, task, board.on(task))
    if spans_tasks(board):
        console.print()
        print_overview(console, board)
    if details:
        console.print()
        print_details(console, board)
    if details and (compared := [one for task in board.tasks for one in compared_to_best(board, task)]):
        console.print()
        print_comparisons(console, compared)
    if board.transfer:
        print_transfers(console, board.transfer.rows)
    if board.trainings:
        print_trainings(console, board.trainings)
    if details and board.efficiency:
        console.print()
        print_efficiencies(console, board.efficiency)
