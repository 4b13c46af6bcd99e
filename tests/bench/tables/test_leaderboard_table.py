"""What ``leaderboard show`` prints: short by default, everything with details, whatever the width and the names."""

from pathlib import Path

import pytest

from hhrl_bench.evaluation.metrics import HEADLINE, compared
from hhrl_bench.leaderboard.entry import write_entry
from hhrl_bench.leaderboard.record import LeaderboardRecord, compared_to_best
from support.command_line import invoke
from support.whole_board import AGENTS, whole_board

COMPARED = [metric.key for metric in compared()]

LONG = "my_agents/careful_driver_of_mine:make_a_very_careful_agent"


def shown(board: LeaderboardRecord, folder: Path, *arguments: str, columns: int | None = None) -> str:
    write_entry(board, folder / "a.json")
    result = invoke("leaderboard", "show", str(folder / "a.json"), *arguments, columns=columns)
    assert result.exit_code == 0, result.output
    return result.stdout


def test_details_add_worst_cases_comparisons_and_efficiency(tmp_path: Path) -> None:
    short, long = (" ".join(shown(whole_board(), tmp_path, *one).split()) for one in ([], ["--details"]))
    for said in ("Worst cases on stop-line-v0", "minus rule-4 on stop-line-v0", "Thousand env steps to 93%"):
        assert said not in short
        assert said in long
    assert long.startswith(short[:500])


def test_worst_cases_count_collisions_and_name_the_worst_seed(tmp_path: Path) -> None:
    lines = [line.split() for line in shown(whole_board(), tmp_path, "--details").splitlines()]
    metrics = whole_board().results[1].metrics
    assert metrics.collision.mean is not None
    assert metrics.impact_speed.mean is not None
    hits = str(round(20 * metrics.collision.mean))
    row = next(row for row in lines if row[:1] == ["rule-2"] and "of" in row)
    assert row[2:6] == [hits, "of", "20", f"{metrics.impact_speed.mean:.2f}"]


@pytest.mark.parametrize("columns", [40, 80, 120, 200])
def test_every_table_fits_and_breaks_no_word_of_a_name(tmp_path: Path, columns: int) -> None:
    lines = shown(whole_board("a-hybrid-method-plus"), tmp_path, "--details", columns=columns).splitlines()
    assert max(map(len, lines)) <= columns
    words = {word for line in lines for word in line.replace("-", " ").split()}
    assert {"hybrid", "method", "plus"} <= words
    assert not {"metho", "hybri", "pl"} & words


@pytest.mark.parametrize("name", ["[bold]x[/bold]", "[/x]", ":smile:", LONG])
def test_names_are_text_whatever_they_hold(tmp_path: Path, name: str) -> None:
    text = shown(whole_board(name), tmp_path, "--details", columns=200)
    assert all(piece in text for piece in name.split("/"))


def test_every_agent_but_the_best_is_compared_to_it() -> None:
    board = whole_board()
    for task in board.tasks:
        pairs = compared_to_best(board, task)
        best = max(board.on(task), key=lambda result: getattr(result.metrics, HEADLINE).mean or 0.0)
        assert {one.other for one in pairs} == {best.agent}
        others = [agent for agent in AGENTS if agent != best.agent]
        assert [(one.agent, one.metric) for one in pairs] == [(agent, key) for agent in others for key in COMPARED]
        for one in pairs:
            own = next(result for result in board.on(task) if result.agent == one.agent)
            expected = (getattr(own.metrics, one.metric).mean or 0.0) - (getattr(best.metrics, one.metric).mean or 0.0)
            assert one.difference.mean == pytest.approx(expected)
