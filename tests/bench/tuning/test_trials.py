from dataclasses import replace

import numpy as np
import pytest

from hhrl_agents.rules.rule_plus import RulePlus
from hhrl_agents.rules.tuning import FIRST_TUNING
from hhrl_bench.evaluation.metrics import METRICS
from hhrl_bench.evaluation.paired_evaluation import play
from hhrl_bench.tasks.tasks import TRAIN
from hhrl_bench.tuning.search import _stacked
from hhrl_bench.tuning.trials import Budget, scores
from hhrl_envs import get_scenario

WORLD = get_scenario("stop-line-noisy-v0")
SEEDS = TRAIN.take(6)


TUNINGS = (FIRST_TUNING, replace(FIRST_TUNING, headway=0.8, speed_share=0.7), FIRST_TUNING)


def test_candidates_score_side_by_side_what_they_score_alone() -> None:
    budget = Budget(10**9)
    together = scores(RulePlus(WORLD, _stacked(TUNINGS, len(SEEDS))), 3, WORLD, SEEDS, budget)
    records = [play(RulePlus(WORLD, one), WORLD, SEEDS).records for one in TUNINGS]
    alone = [METRICS["score"].values(one).mean() for one in records]
    assert together is not None
    np.testing.assert_allclose(together, alone, rtol=1e-12)
    assert together[0] == together[2] != together[1]
    assert budget.spent == sum(int(one.steps.sum()) for one in records)


@pytest.mark.parametrize("short", [1, 5, 500])
def test_a_budget_is_never_exceeded(short: int) -> None:
    agent, whole = RulePlus(WORLD), Budget(10**9)
    assert scores(agent, 2, WORLD, SEEDS, whole) is not None
    exact, less = Budget(whole.spent), Budget(whole.spent - short)
    assert scores(agent, 2, WORLD, SEEDS, exact) is not None
    assert scores(agent, 2, WORLD, SEEDS, less) is None
    assert exact.spent == exact.total
    assert less.total - 2 * len(SEEDS) < less.spent <= less.total
