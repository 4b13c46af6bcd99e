"""docs/traffic.md says of egos behind the adversary what the published leaderboard holds."""

import re
from pathlib import Path

import pytest

from hhrl_bench.evaluation.records import ResultRecord, RunTrafficRecord
from hhrl_bench.leaderboard.entry import read_entry

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "traffic.md").read_text()
RESULTS = {
    result.agent: result
    for result in read_entry(ROOT / "leaderboards" / "robustness.json").results
    if result.task == "adversary-v0"
}
ROWS = {"Double DQN": "ddqn", "Hybrid HRL": "hybrid-hrl", "Hybrid HRL plus": "hybrid-hrl-plus"}


def counts(result: ResultRecord) -> list[RunTrafficRecord]:
    return [run.traffic for run in result.runs if run.traffic]


@pytest.mark.parametrize("row", ROWS)
def test_the_success_behind_the_adversary(row: str) -> None:
    result = RESULTS[ROWS[row]]
    (line,) = re.findall(rf"^\| {row} \| (.*%) \|$", PAGE, re.MULTILINE)
    cells = str(line).split(" | ")
    assert cells[0] == f"{result.metrics.success.mean:.1%}"
    assert cells[-1] == ", ".join(f"{100 * run.metrics.success:.1f}" for run in result.runs) + "%"


def test_no_rule_has_failed_behind_it() -> None:
    for agent in ("rule-3", "rule-4", "rule-plus"):
        assert RESULTS[agent].metrics.success.mean == 1.0


def test_how_often_the_adversary_succeeds_without_a_collision_of_its_own() -> None:
    succeeded = {
        row: sum(one.vehicles[1].get("success", 0) for one in counts(RESULTS[agent])) / 5_000
        for row, agent in ROWS.items()
    }
    said = "Double DQN fail in {:.0%} of all episodes, Hybrid HRL in {:.0%} and Hybrid HRL plus in {:.0%}"
    assert said.format(*succeeded.values()) in " ".join(PAGE.split())
