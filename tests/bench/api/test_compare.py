"""``compare``: the differences are those that entries hold, in the same worlds alone."""

from pathlib import Path

import numpy as np
import pytest

from hhrl_bench import Evaluation, compare, evaluate
from hhrl_bench.errors import AgentError, RecordError
from hhrl_bench.leaderboard.entry import read_entry

ROOT = Path(__file__).parents[3]
EPISODES = 24


@pytest.fixture(scope="module")
def several() -> Evaluation:
    return evaluate(["rule-2", "rule-4", "hybrid-hrl"], episodes=EPISODES)


def test_single_policies_are_paired_world_by_world(several: Evaluation) -> None:
    a, b = several["rule-2"], several["rule-4"]
    comparison = compare(a, b)
    differences = a.steps - b.steps
    steps = comparison["steps"].difference
    assert steps.mean == pytest.approx(differences.mean())
    assert steps.interval == "bootstrap-episodes"
    rng = np.random.default_rng(0)
    resampled = [rng.choice(differences, EPISODES).mean() for _ in range(2000)]
    assert (steps.low, steps.high) == pytest.approx(np.quantile(resampled, [0.025, 0.975]), rel=0.05)
    assert comparison["steps"].probability_more is None
    assert compare("rule-2", b).records == comparison.records
    assert comparison.records[0].metric == "return_task"
    assert "impact_speed" not in {one.metric for one in comparison.records}


def test_training_seeds_give_a_probability_and_a_table(several: Evaluation) -> None:
    comparison = compare(several["hybrid-hrl"], several["rule-2"])
    success = comparison["success"]
    assert (success.runs, success.other_runs, success.difference.interval) == (5, 1, "bootstrap-seeds")
    assert success.probability_more is not None
    assert success.probability_more.mean == 1.0
    assert f"minus rule-2 on stop-line-v0, {EPISODES} test episodes" in str(comparison)
    frame = comparison.to_frame().set_index("metric")
    assert frame.loc["success", "low"] == success.difference.low


def test_it_is_the_comparison_of_a_published_entry() -> None:
    board = read_entry(ROOT / "leaderboards" / "quick.json")
    wanted = "rule-3", "rule-4", "success"
    pairs = [one for one in board.comparisons if (one.agent, one.other, one.metric) == wanted]
    assert [one.task for one in pairs] == [task.id for task in board.tasks]
    published = pairs[0]
    assert compare("rule-3", "rule-4", published.task, published.episodes)["success"] == published


def test_what_cannot_be_compared_is_said_in_a_line(several: Evaluation) -> None:
    with pytest.raises(RecordError, match="24 episodes of stop-line-v0 and 5 of stop-line-v0 are not the same worlds"):
        compare(several["rule-2"], evaluate("rule-4", episodes=5))
    with pytest.raises(AgentError, match="rule-2 is compared to itself"):
        compare(several["rule-2"], "rule-2")
    with pytest.raises(RecordError, match="no metric 'politeness'; it has return_task"):
        compare(several["rule-2"], several["rule-4"])["politeness"]
