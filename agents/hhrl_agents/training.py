"""The learner that a method asks for."""

from collections.abc import Iterator, Sequence
from typing import Protocol

import numpy as np
import numpy.typing as npt

from hhrl_agents.learned import LearnedAgent
from hhrl_agents.learners import Learner, Progress
from hhrl_agents.methods import Method
from hhrl_agents.pqn import PQNLearner
from hhrl_envs import Scenario
from hhrl_envs.extras import require


class AnyLearner(Protocol):
    """What trains E independent seeds of one method at once; see `hhrl_agents.learners.Learner`."""

    env_steps: int
    updates: int

    def train(self, env_steps: int) -> Iterator[Progress]:
        """Yield reports while training for `env_steps`."""

    def policies(self) -> list[LearnedAgent]:
        """Return each seed's greedy policy as it is now."""


def make_learner(
    method: Method, scenario: Scenario, seeds: Sequence[int], world_seeds: npt.NDArray[np.uint64]
) -> AnyLearner:
    """Return the learner of the method's algorithm; see `Learner` for the arguments.

    Raises:
        MissingExtraError: if the algorithm is a library's that is not installed.
    """
    if method.algorithm == "ppo":
        require("stable_baselines3", "sb3")
        from hhrl_agents.ppo import PPOLearner  # noqa: PLC0415

        return PPOLearner(method, scenario, seeds, world_seeds)
    kind = PQNLearner if method.algorithm == "pqn" else Learner
    return kind(method, scenario, seeds, world_seeds)
