import numpy as np
import pytest

from hhrl_agents import RULES
from hhrl_bench.evaluation.metrics import METRICS
from hhrl_bench.evaluation.paired_evaluation import play
from hhrl_bench.tasks.tasks import TRAIN
from hhrl_bench.tuning.trials import Budget, scores
from hhrl_envs import get_scenario

WORLD = get_scenario("stop-line-noisy-v0")
SEEDS = TRAIN.take(6)


def test_candidates_score_side_by_side_what_they_score_alone() -> None:
    agents = [RULES[rule](WORLD) for rule in ("rule-3", "rule-plus", "rule-3")]
    budget = Budget(10**9)
    together = scores(agents, WORLD, SEEDS, budget)
    records = [play(agent, WORLD, SEEDS).records for agent in agents]
    alone = [METRICS["score"].values(one).mean() for one in records]
    assert together is not None
    np.testing.assert_allclose(together, alone, rtol=1e-12)
    assert budget.spent == sum(int(one.steps.sum()) for one in records)


@pytest.mark.parametrize("short", [1, 5, 500])
def test_a_budget_is_never_exceeded(short: int) -> None:
    agents = [RULES["rule-plus"](WORLD)] * 2
    whole = Budget(10**9)
    assert scores(agents, WORLD, SEEDS, whole) is not None
    exact, less = Budget(whole.spent), Budget(whole.spent - short)
    assert scores(agents, WORLD, SEEDS, exact) is not None
    assert scores(agents, WORLD, SEEDS, less) is None
    assert exact.spent == exact.total
    assert less.total - 2 * len(SEEDS) < less.spent <= less.total
