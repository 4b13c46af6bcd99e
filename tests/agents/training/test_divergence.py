"""Values that no sum of discounted rewards can reach."""

from dataclasses import replace

import numpy as np
import pytest

from hhrl_agents import METHODS
from hhrl_agents.algorithms.double_dqn import DoubleDQNLearner, beyond_bound
from hhrl_envs import get_scenario

SCENARIO = get_scenario("stop-line-v0")


def test_the_level_is_named_whose_values_lie_beyond_what_the_rewards_allow() -> None:
    said = "its option values reach 20.5, the rewards allow 20"
    assert beyond_bound({"option": 20.5, "action": 4.0}, 2.0, 0.9) == said
    assert beyond_bound({"option": 20.5, "action": 4.0}, 3.0, 0.9) is None
    reached = beyond_bound({"option": 1.0, "action": 10.0}, 0.5, 0.9)
    assert reached == "its action values reach 10, the rewards allow 5"


def test_without_a_discount_nothing_is_beyond() -> None:
    assert beyond_bound({"action": 1e30}, 1.0, 1.0) is None


@pytest.mark.parametrize("alpha", [0.0, 0.5])
def test_advantage_learning_reaches_further(alpha: float) -> None:
    """With a share alpha of the shortfall taken off, values reach (1 + alpha) / (1 - alpha) times as far."""
    values = {"hidden": (8,), "n_envs": 4, "batch_size": 8, "replay_capacity": 400, "warmup": 40, "report_every": 80}
    config = replace(METHODS["ddqn"].config, **values, advantage_learning=alpha)
    learner = DoubleDQNLearner(replace(METHODS["ddqn"], config=config), SCENARIO, 3, np.arange(4, dtype=np.uint64))
    next(learner.train(80))
    usual = config.reward_scale * max(SCENARIO.reward.sigma_3, SCENARIO.reward.sigma_4)
    largest = max(learner._replay.largest_reward(), usual)
    bound = largest / (1.0 - config.gamma) * (1.0 + alpha) / (1.0 - alpha)
    assert learner._diverged() is None  # no mini-batch since the report
    learner._has_values = True
    for share, diverged in ((0.99, False), (1.01, True)):
        learner._found.largest[:] = share * bound
        assert (learner._diverged() is not None) == diverged
