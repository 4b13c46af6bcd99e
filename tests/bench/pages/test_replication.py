"""REPLICATION.md says of the paper suite what its published leaderboard holds."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hhrl_bench.evaluation.loading import load_agent
from hhrl_bench.evaluation.records import MetricRecord
from hhrl_bench.evaluation.rollout import Rollout
from hhrl_bench.leaderboard.comparisons import Runs, compare
from hhrl_bench.leaderboard.entry import read_entry
from hhrl_bench.statistics.intervals import bootstrap_mean
from hhrl_bench.tasks.tasks import get_task
from hhrl_bench.training.learning_curves import Curve, area
from hhrl_envs import Option, get_scenario, observation
from hhrl_envs.simulation.rewards import UNSAFE

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "REPLICATION.md").read_text()
BOARD = read_entry(ROOT / "leaderboards" / "paper.json")
RESULTS = {result.agent: result.metrics for result in BOARD.results}
AREAS = {
    training.method: Runs(
        training.method,
        [np.array([area(Curve(training.env_steps, tuple(row)))]) for row in training.testing.array("success").tolist()],
    )
    for training in BOARD.trainings
}
TRAININGS = {
    "`follow-only` in `red-light-v0`, option held at FFV": "follow-only",
    "`option-only` over a rule-based stop and a trained follower": "option-only",
    "`hybrid-hrl` in `stop-line-v0`, both levels": "hybrid-hrl",
}
ROWS = {"rule-1": "Rule 1", "rule-2": "Rule 2", "rule-3": "Rule 3", "rule-4": "Rule 4", "hybrid-hrl": "Hybrid HRL"}
ADDED = {
    ("hybrid reward", "hrl-0"): "hrl-1",
    ("hierarchical replay", "hrl-1"): "hrl-2",
    ("hierarchical replay", "hrl-3"): "hybrid-hrl",
    ("attention", "hrl-1"): "hrl-3",
    ("attention", "hrl-2"): "hybrid-hrl",
    ("all three", "hrl-0"): "hybrid-hrl",
    ("options and all three", "ddqn"): "hybrid-hrl",
}


def cells(first: str) -> list[str]:
    """Return the other cells of the line of a table whose first cell begins so."""
    (line,) = re.findall(rf"^\| {re.escape(first)} \| (.*) \|$", PAGE, re.MULTILINE)
    return [cell.strip() for cell in str(line).split("|")]


def said(metric: MetricRecord, digits: int, *, percent: bool = False) -> str:
    assert metric.mean is not None
    assert metric.low is not None
    assert metric.high is not None
    scale = 100.0 if percent else 1.0
    low, high = (f"{bound * scale:.{digits}f}" for bound in (metric.low, metric.high))
    high = "100" if percent and float(high) == 100.0 else high
    return f"{metric.mean * scale:.{digits}f}{'%' * percent} ({low}, {high})"


@pytest.mark.parametrize("agent", ROWS)
def test_table_1(agent: str) -> None:
    learned = agent == "hybrid-hrl"
    rewards, unsafe, rates = (2, 2, 2) if learned else (1, 1, 1)
    metrics = RESULTS[agent]
    assert cells(f"{ROWS[agent]}, n = {'10' if learned else '1,000'}") == [
        said(metrics.return_option, rewards),
        said(metrics.return_action, rewards),
        said(metrics.steps, 0),
        said(metrics.unsmooth, 2),
        said(metrics.unsafe, unsafe),
        *(said(rate, rates, percent=True) for rate in (metrics.collision, metrics.not_stop, metrics.success)),
    ]


@pytest.mark.parametrize("method", AREAS)
def test_the_variants(method: str) -> None:
    (soon,) = (record for record in BOARD.efficiency if record.method == method)
    assert soon.steps.median is not None
    assert soon.low is not None
    assert soon.high is not None
    estimate = bootstrap_mean(np.concatenate(AREAS[method].values), np.random.default_rng(0), "bootstrap-seeds")
    assert cells(f"`{method}`")[-3:] == [
        said(RESULTS[method].success, 2, percent=True),
        f"{soon.steps.median / 1000:.0f} ({soon.low / 1000:.0f}, {soon.high / 1000:.0f})",
        f"{estimate.mean:.3f} ({estimate.low:.3f}, {estimate.high:.3f})",
    ]


@pytest.mark.parametrize(("part", "to"), ADDED)
def test_what_each_part_adds(part: str, to: str) -> None:
    difference = compare(
        AREAS[ADDED[part, to]], AREAS[to], "stop-line-paper-v0", "area", np.random.default_rng(0)
    ).difference
    assert f"| {part} | `{to}` | {difference.mean:+.3f} ({difference.low:+.3f}, {difference.high:+.3f}) |" in PAGE


@pytest.mark.parametrize(
    ("better", "worse", "points"),
    [
        ("ddqn", "hrl-1", "0.10 points (0.03, 0.18)"),
        ("ddqn", "hrl-3", "0.07 points (0.02, 0.12)"),
        ("hrl-0", "hrl-1", "0.10 points (0.03, 0.18)"),
        ("hrl-0", "hrl-3", "0.07 points (0.02, 0.12)"),
        ("hybrid-hrl", "hrl-1", "0.08 points (0.01, 0.16)"),
    ],
)
def test_which_methods_succeed_more_often(better: str, worse: str, points: str) -> None:
    pairs = (one for one in BOARD.comparisons if one.metric == "success")
    (one,) = (one for one in pairs if {one.agent, one.other} == {better, worse})
    percent, found = 100.0 if one.agent == better else -100.0, one.difference
    numbers = [percent * (bound or 0.0) for bound in (found.mean, found.low, found.high)]
    assert points == f"{numbers[0]:.2f} points ({min(numbers[1:]):.2f}, {max(numbers[1:]):.2f})"
    assert points in " ".join(PAGE.split())


@pytest.mark.parametrize("row", TRAININGS)
def test_the_three_trainings(row: str) -> None:
    board = read_entry(ROOT / "leaderboards" / "trainings.json")
    (metrics,) = (result.metrics for result in board.results if result.agent == TRAININGS[row])
    rates = (metrics.success, metrics.collision, metrics.not_stop, metrics.timeout)
    assert cells(row) == [said(rate, 2, percent=True) for rate in rates]


@pytest.mark.parametrize("agent", ["rule-1", "hybrid-hrl:2", "rule-4", "hybrid-hrl:0"])
def test_how_often_the_unsafe_term_is_not_the_printed_one(agent: str) -> None:
    (row,) = re.findall(rf"^\| `{agent}` \| (stop-line\S*) \| (.*) \| (.*) \| (.*) \|$", PAGE, re.MULTILINE)
    task = get_task(row[0])
    built = get_scenario(task.scenario)
    printed = replace(built, reward=replace(built.reward, unsafe="printed"))
    seeds = np.arange(task.test.start, task.test.start + 1000, dtype=np.uint64)
    rollouts = (Rollout(load_agent(agent, task.id), scenario, seeds) for scenario in (built, printed))
    steps = count = 0
    most = np.zeros(2)  # before the line, past it
    for ours, theirs in zip(*rollouts, strict=True):
        difference = np.abs(theirs.results.terms - ours.results.terms)[:, UNSAFE[Option.SSL]]
        past = ours.results.observations[:, observation.D_D] < 0.0
        steps, count = steps + int(ours.running.sum()), count + int((difference > 0.0).sum())
        most = np.maximum(most, [difference[~past].max(initial=0.0), difference[past].max(initial=0.0)])
    assert [1000.0 * count / steps, *most] == pytest.approx([float(cell) for cell in row[1:]], rel=5e-3, abs=5e-3)
