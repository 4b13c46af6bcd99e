"""Values that no sum of discounted rewards can reach."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from hhrl_agents import METHODS
from hhrl_agents.algorithms.double_dqn import DoubleDQNLearner, beyond_bound
from hhrl_envs import get_scenario

SCENARIO = get_scenario("stop-line-v0")


def test_seeds_are_named_whose_values_lie_beyond_what_their_rewards_allow() -> None:
    values = {"option": torch.tensor([[[9.0, -10.0]], [[1.0, -20.5]]]), "action": torch.tensor([[[3.0]], [[-4.0]]])}
    assert beyond_bound(values, np.array([1.0, 2.0]), 0.9) == {
        1: "its option values reach 20.5, the rewards allow 20",
    }
    assert set(beyond_bound(values, np.array([0.5, 3.0]), 0.9)) == {0}


def test_without_a_discount_nothing_is_beyond() -> None:
    assert not beyond_bound({"action": torch.full((1, 1, 1), 1e30)}, np.array([1.0]), 1.0)


@pytest.mark.parametrize("alpha", [0.0, 0.5])
def test_advantage_learning_reaches_further(alpha: float) -> None:
    """With a share alpha of the shortfall taken off, values reach (1 + alpha) / (1 - alpha) times as far."""
    values = {"hidden": (8,), "n_envs": 4, "batch_size": 8, "replay_capacity": 400, "warmup": 40, "report_every": 80}
    config = replace(METHODS["ddqn"].config, **values, advantage_learning=alpha)
    learner = DoubleDQNLearner(
        replace(METHODS["ddqn"], config=config), SCENARIO, (3, 5), np.arange(8, dtype=np.uint64).reshape(2, 4)
    )
    next(learner.train(80))
    usual = config.reward_scale * max(SCENARIO.reward.sigma_3, SCENARIO.reward.sigma_4)
    largest = np.maximum(learner._replay.largest_reward(), usual)
    bound = largest / (1.0 - config.gamma) * (1.0 + alpha) / (1.0 - alpha)
    for share, diverged in ((0.99, set()), (1.01, {0, 1})):
        learner._values = {"action": torch.from_numpy(share * bound).view(2, 1, 1)}
        assert set(learner._diverged()) == diverged
