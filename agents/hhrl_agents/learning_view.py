"""The Gymnasium view, with the rewards that learners learn from."""

from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from hhrl_agents.ppo_config import PPOConfig
from hhrl_envs import Outcome, Scenario
from hhrl_envs.gym_env import StopLineEnv
from hhrl_envs.rewards import TIMEOUT, UNSMOOTH

Observation = NDArray[np.float32]


class LearningView(gymnasium.Wrapper[Observation, Any, Observation, Any]):
    """One environment of a learner: episode after episode of the world `world_seed`, with scaled rewards.

    Where a time limit counts as truncation its penalty is left out; else it terminates. `info` holds `outcome` alone.
    """

    def __init__(self, scenario: Scenario, config: PPOConfig, world_seed: int) -> None:
        self._view = StopLineEnv(scenario)
        super().__init__(self._view)
        self._config = config
        self._first_seed: int | None = world_seed

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Return the first observation, float32 [11], of the world's next episode, whatever the seed, and no info."""
        seed, self._first_seed = self._first_seed, None
        return self._view.reset(seed=seed, options=options)[0], {}

    def step(self, action: Any) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Return observation, scaled r^task, terminated, truncated and the outcome after one step."""
        observation, reward, terminated, truncated, info = self._view.step(action)
        terms = self._view.parallel.simulator.terms[0]
        reward -= (1.0 - self._config.jerk_weight) * float(terms[UNSMOOTH])
        if truncated and self._config.timeout == "truncation":
            reward -= float(terms[TIMEOUT])
        elif truncated:
            terminated, truncated = True, False
        outcome = {"outcome": info.get("outcome", Outcome.RUNNING)}
        return observation, reward * self._config.reward_scale, terminated, truncated, outcome
