"""The learner that a method asks for."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from hhrl_agents.learners import Learner
from hhrl_agents.methods import Method
from hhrl_agents.pqn import PQNLearner
from hhrl_agents.progress import TrainableStack
from hhrl_envs import Scenario
from hhrl_envs.extras import require


def make_learner(
    method: Method, scenario: Scenario, seeds: Sequence[int], world_seeds: npt.NDArray[np.uint64]
) -> TrainableStack:
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
