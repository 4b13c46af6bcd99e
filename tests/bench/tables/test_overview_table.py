"""One row an agent: its success on every task, and what to know of it."""

from io import StringIO

import pytest
from rich.console import Console

from hhrl_bench.evaluation.records import OpponentRecord, TrafficRecord
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.tables.markdown import suite_page
from hhrl_bench.tables.results import results_table
from hhrl_bench.tables.success import results_by_row, spans_tasks, success_table
from hhrl_bench.tables.terminal import print_table
from support.whole_board import AGENTS, whole_board


def printed(board: LeaderboardRecord, width: int) -> str:
    console = Console(file=StringIO(), width=width)
    print_table(console, success_table(board.tasks, [board]))
    assert isinstance(console.file, StringIO)
    return console.file.getvalue()


def without(board: LeaderboardRecord, agent: str, task: str) -> LeaderboardRecord:
    kept = tuple(one for one in board.results if (one.agent, one.task) != (agent, task))
    return board.model_copy(update={"results": kept})


def test_every_agent_has_one_row_with_its_success_on_each_task() -> None:
    board = whole_board()
    rows = success_table(board.tasks, [board]).groups[0].rows
    assert tuple(row.name for row in rows) == AGENTS
    for row in rows:
        own = {one.task: one.metrics.success.mean or 0.0 for one in board.results if one.agent == row.name}
        assert [cell.value for cell in row.cells] == [f"{own[task.id]:.1%}" for task in board.tasks]
        assert all(f"{cell.value} " in printed(board, 200).replace("\n", " ") for cell in row.cells)


def test_success_behind_an_opponent_is_what_it_is_everywhere_the_share_of_all_episodes() -> None:
    board = whole_board()
    (own,) = (one for one in board.on(board.tasks[0]) if one.agent == "rule-2")
    shares = TrafficRecord(feasible=own.metrics.collision, success_feasible=own.metrics.timeout)
    behind = own.model_copy(update={"traffic": shares})
    opponent = OpponentRecord(agent="adversary", checkpoint_sha256=None)
    task = board.tasks[0].model_copy(update={"opponent": opponent})
    board = board.model_copy(update={"tasks": (task,), "results": (behind,)})
    across, alone = success_table([task], [board]), results_table(task, [behind])
    (place,) = (place for place, one in enumerate(alone.columns) if one.line == "success")
    assert across.groups[0].rows[0].cells == (alone.groups[0].rows[0].cells[place],)
    assert own.metrics.success.mean not in {shares.feasible.mean, shares.success_feasible.mean}
    said = f"stop-line-v0: behind adversary; {shares.feasible.mean:.1%} of the episodes were feasible."
    assert said in [note.text for note in across.notes]


def test_what_was_not_played_is_a_dash() -> None:
    board = without(whole_board(), "rule-4", "stop-line-wet-v0")
    row = success_table(board.tasks, [board]).groups[0].rows[-1]
    assert [cell.value is None for cell in row.cells] == [False, True]
    last = next(line for line in printed(board, 200).splitlines() if line.startswith("rule-4"))
    assert last.split()[-1] == "\N{EN DASH}"


def test_a_held_option_is_a_row_of_its_own() -> None:
    board = whole_board()
    held = board.results[0].model_copy(update={"option": "follow"})
    names = list(results_by_row(board.model_copy(update={"results": (*board.results, held)})))
    assert names == [*AGENTS, "rule-1, follow held"]


def test_a_failed_seed_is_named() -> None:
    board = whole_board()
    failed = board.results[0].model_copy(update={"failed_seeds": (3, 5, 6)})
    board = board.model_copy(update={"results": (failed, *board.results[1:])})
    _, note = success_table(board.tasks, [board]).notes
    assert note.text == "rule-1 on stop-line-v0: without seeds 3,5-6, whose training failed."


def test_agents_on_one_task_each_are_not_put_side_by_side() -> None:
    board = whole_board()
    assert spans_tasks(board)
    for agent in AGENTS:
        board = without(board, agent, "stop-line-wet-v0")
    assert not spans_tasks(board)
    assert "Success on every task" not in suite_page({"a": board})


@pytest.mark.parametrize("width", [24, 40, 80, 120])
def test_it_fits_and_says_when_tasks_are_missing(width: int) -> None:
    text = printed(whole_board("a-hybrid-method-plus"), width)
    assert max(map(len, text.splitlines())) <= width
    assert ("more tasks" in " ".join(text.split())) == (width == 24)
