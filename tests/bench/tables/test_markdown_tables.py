"""Markdown tables: every entry's rows in one table a task, names inert, equal text for equal leaderboards."""

import re
from pathlib import Path

import pytest

from hhrl_bench.leaderboard.entry import read_entry
from hhrl_bench.leaderboard.record import LeaderboardRecord, standing
from hhrl_bench.paper_table import TABLE_I
from hhrl_bench.tables.markdown import plain, suite_page
from support.whole_board import AGENTS, whole_board

PUBLISHED = Path(__file__).parents[3] / "leaderboards"
HOSTILE = (
    "a|b",
    "a\\|b",
    "`x`",
    "<script>",
    "[x](http://a.example)",
    "a \N{EM SPACE}|",
    "*x* _y_ ~z~ $1$",
)


def tables(page: str) -> list[list[list[str]]]:
    """Return the cells of every table, as a reader of Markdown splits them."""
    lines = [line if line.startswith("|") else "" for line in page.splitlines()]
    blocks = [block.splitlines() for block in "\n".join(lines).split("\n\n") if block.strip()]
    return [[re.split(r"(?<!\\)(?:\\\\)*\|", line.strip())[1:-1] for line in block if line] for block in blocks]


def section(page: str, heading: str) -> str:
    return page.split(f"\n{heading}\n", 1)[1].split("\n#", 1)[0]


def names(text: str) -> list[str]:
    return [row[0].strip() for row in tables(text)[0][2:]]


@pytest.fixture(scope="module")
def page() -> str:
    return suite_page({"published": whole_board(), "theirs": whole_board("other")})


def test_rows_of_all_entries_stand_by_success(page: str) -> None:
    text = section(
        page, "## stop-line-v0\n\n20 test episodes, the worlds of seeds 2000000000 to 2000000019.\n\n### Results"
    )
    assert names(text) == ["rule-4", "rule-4", "rule-2", "other", "rule-1", "rule-1"]
    entries = [row[-1].strip() for row in tables(text)[0][2:8]]
    assert entries == ["published", "theirs"] * 3


def test_those_without_a_score_stand_behind_those_with_one_and_an_oracle_behind_all() -> None:
    board = read_entry(PUBLISHED / "quick.json")
    names_of = {result.agent: result for result in board.on(board.tasks[0])}
    poor, rich, seer = (names_of[name] for name in ("rule-1", "rule-4", "oracle"))
    others = {
        metric.key: rich.metrics.get(metric.key) for metric in rich.metrics.declarations() if metric.key != "score"
    }
    unscored = rich.model_copy(update={"metrics": rich.metrics.model_validate(others)})
    assert sorted([seer, unscored, poor], key=standing, reverse=True) == [poor, unscored, seer]
    _, first = suite_page({"quick": board}).split(f"\n## {board.tasks[0].id}\n")
    assert names(section(first, "### Results"))[-1] == "oracle"


def test_the_papers_rows_stand_below_the_task_of_its_world_only(page: str) -> None:
    assert "the paper" not in page
    text = section(suite_page({"paper": read_entry(PUBLISHED / "paper.json")}), "### Results")
    assert names(text)[-len(TABLE_I) - 1 :] == ["**the paper**", *(row.policy for row in TABLE_I)]


def test_every_table_has_as_many_cells_in_every_row(page: str) -> None:
    found = tables(page)
    assert len(found) >= 10
    for table in found:
        assert len({len(row) for row in table}) == 1


def test_success_has_its_interval_and_the_command_its_commit(page: str) -> None:
    board = whole_board()
    success, commit = board.results[2].metrics.success, board.provenance.git_commit
    assert None not in {success.mean, success.low, success.high}
    row = next(row for row in tables(page)[1] if row[0].strip() == "rule-4")
    assert re.fullmatch(r"\d+\.\d% \(\d+(\.\d)?, \d+(\.\d)?\)", row[9].strip())
    assert not [cell for cell in row[1:9] if "(" in cell]
    assert board.provenance.command in page
    assert commit is None or f"commit {commit}" in page


def test_comparisons_efficiency_and_transfer_are_told_of_every_entry(page: str) -> None:
    for entry in ("published", "theirs"):
        assert f"### Score, success, less that of rule-4, {entry}" in page
        assert f"### Sensitivity to the weights of the score, {entry}" in page
        assert f"## Thousand env steps to 93% validation success, {entry}" in page
        assert f"## hybrid-hrl trained on stop-line-v0, seeds 0-2,5, {entry}" in page


def test_worlds_that_differ_are_not_put_together() -> None:
    board = whole_board()
    other = board.model_copy(update={"tasks": tuple(task.model_copy(update={"episodes": 40}) for task in board.tasks)})
    page = suite_page({"a": board, "b": other})
    assert page.count("\n## stop-line-v0\n") == 2
    assert len(names(section(page, "### Results"))) == len(AGENTS)


@pytest.mark.parametrize("name", HOSTILE)
def test_names_are_text_whatever_they_hold(name: str) -> None:
    page, usual = suite_page({name: whole_board(name)}), suite_page({"x": whole_board()})
    assert plain(name) in page
    assert "\n" not in plain(name)
    assert [len(row) for table in tables(page) for row in table] == [
        len(row) for table in tables(usual) for row in table
    ]
    assert not re.search(r"(?<!\\)[`<\[$~]", page)


def test_plain_text_stays_readable() -> None:
    for text in ("hybrid-hrl-plus", "99.6% (99.1, 100)", "hhrl-bench run --suite quick", "Worst seed: 1, in brackets."):
        assert plain(text) == text


def test_equal_leaderboards_give_equal_text(page: str) -> None:
    again = [LeaderboardRecord.model_validate_json(whole_board(name).model_dump_json()) for name in ("rule-2", "other")]
    assert suite_page(dict(zip(("published", "theirs"), again, strict=True))) == page
