"""The pages say of the suite ``full`` what its published leaderboard holds."""

import re
from pathlib import Path

import pytest

from hhrl_bench.evaluation.records import ResultRecord
from hhrl_bench.leaderboard.entry import read_entry
from hhrl_bench.tables.results import worst_run
from hhrl_bench.tables.success import success_cell

ROOT = Path(__file__).parents[3]
BOARD = read_entry(ROOT / "leaderboards" / "full.json")
RESULTS = {(result.task, result.agent): result for result in BOARD.results}
LEARNED = ("ddqn", "ddqn-plus", "hybrid-hrl", "hybrid-hrl-plus", "pqn")
PAGES = {
    "README.md": ("rule-plus", "ddqn", "hybrid-hrl", "ddqn-plus", "hybrid-hrl-plus"),
    "docs/learning.md": ("rule-plus", *LEARNED),
}


def said(result: ResultRecord) -> str:
    """Return how often a result succeeds as the tables say it."""
    cell = success_cell(result)
    return f"{cell.value} ({cell.bounds})"


def worst(result: ResultRecord) -> str:
    lowest = f"{worst_run(result).metrics.success * 100:.1f}".replace("100.0", "100")
    return f", {lowest}" if len(result.runs) > 1 else ""


@pytest.mark.parametrize("page", PAGES)
@pytest.mark.parametrize("task", [task.id for task in BOARD.tasks])
def test_success_on_every_task(page: str, task: str) -> None:
    lines = re.findall(rf"^\| `{task}` \| (.*%.*\(.*) \|$", (ROOT / page).read_text(), re.MULTILINE)
    results = [RESULTS[task, agent] for agent in PAGES[page]]
    wanted = [said(one) + (worst(one) if page == "docs/learning.md" else "") for one in results]
    assert [cell.strip() for cell in lines[-1].split("|")] == wanted


def test_every_learned_method_has_ten_seeds_and_failed_ones_are_told() -> None:
    seeds = {(task.id, agent): RESULTS[task.id, agent] for task in BOARD.tasks for agent in LEARNED}
    assert {len(one.seeds) + len(one.failed_seeds or ()) for one in seeds.values()} == {10}
    failed = {key: one.failed_seeds for key, one in seeds.items() if one.failed_seeds}
    assert failed == {("stop-line-erratic-v0", "hybrid-hrl"): (9,)}


@pytest.mark.parametrize(
    ("task", "points"),
    [
        ("stop-line-dense-v0", "19.0 points (13.6, 23.7)"),
        ("stop-line-wet-v0", "21.0 (20.8, 21.2)"),
        ("stop-line-erratic-v0", "28.4 (19.2, 36.9)"),
        ("stop-line-noisy-v0", "36.2 (26.9, 45.6)"),
    ],
)
def test_hybrid_hrl_next_to_rule_plus(task: str, points: str) -> None:
    (one,) = [
        one for one in BOARD.comparisons if one.task == task and {one.agent, one.other} == {"rule-plus", "hybrid-hrl"}
    ]
    found = one.difference
    assert found.low is not None
    assert found.high is not None
    low, high = sorted((abs(found.low), abs(found.high)))
    numbers = [f"{100 * value:.1f}" for value in (abs(found.mean or 0.0), low, high)]
    assert re.findall(r"\d+\.\d", points) == numbers
    assert points in " ".join((ROOT / "REPLICATION.md").read_text().split())
