"""The Gymnasium view that a library's learner learns in, beside the simulator itself."""

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest

from hhrl_agents.algorithms.ppo import LearningView
from hhrl_agents.methods.configs import PPOConfig
from hhrl_envs import Outcome, Simulator, get_scenario
from hhrl_envs.simulation.rewards import TIMEOUT, UNSMOOTH
from support.driving import random_actions

SHORT = replace(get_scenario("stop-line-v0"), id="short", horizon=90)
WORLD = 5
STEPS = 600


@pytest.mark.parametrize("weight", [1.0, 0.3, 0.0])
@pytest.mark.parametrize("timeout", ["truncation", "terminal"])
def test_rewards_and_ends_are_the_simulator_s_as_learning_reads_them(
    timeout: Literal["truncation", "terminal"], weight: float
) -> None:
    config = PPOConfig(timeout=timeout, jerk_weight=weight)
    view, simulator = LearningView(SHORT, config, WORLD), Simulator(SHORT, 1)
    simulator.reset(np.array([WORLD], np.uint64))
    np.testing.assert_array_equal(view.reset(seed=99)[0], simulator.observations[0])
    unsmooth, outcomes = 0, set[Outcome]()
    for action in random_actions(1, STEPS, 1, SHORT.num_actions):
        simulator.step(action)
        observation, reward, terminated, truncated, info = view.step(action[0])
        np.testing.assert_array_equal(observation, simulator.observations[0])
        outcome, terms = Outcome(simulator.outcomes[0]), simulator.terms[0]
        expected = simulator.rewards[0] - (1.0 - weight) * terms[UNSMOOTH]
        if timeout == "truncation":
            expected -= terms[TIMEOUT]
        late = outcome == Outcome.TIMEOUT
        assert reward == pytest.approx(config.reward_scale * expected, abs=1e-9)
        assert truncated == (late and timeout == "truncation")
        assert terminated == (outcome != Outcome.RUNNING and not truncated)
        assert info == {"outcome": outcome}
        unsmooth += int(terms[UNSMOOTH] < 0.0)
        outcomes.add(outcome)
        if terminated or truncated:
            simulator.reset_done()
            np.testing.assert_array_equal(view.reset()[0], simulator.observations[0])
    assert unsmooth
    assert {Outcome.RUNNING, Outcome.TIMEOUT} < outcomes
