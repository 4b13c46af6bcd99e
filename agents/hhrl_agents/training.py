"""The learner that a method asks for."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Protocol

import numpy as np
import numpy.typing as npt

from hhrl_agents.learned import LearnedAgent
from hhrl_agents.learners import Learner, Progress
from hhrl_agents.methods import Method
from hhrl_agents.pqn import PQNLearner
from hhrl_envs import Scenario


class AnyLearner(Protocol):
    """What trains E independent seeds of one method at once; see `hhrl_agents.learners.Learner`."""

    env_steps: int
    updates: int

    def train(self, env_steps: int) -> Iterator[Progress]:
        """Yield reports while training for `env_steps`."""

    def policies(self) -> list[LearnedAgent]:
        """Return each seed's greedy policy as it is now."""


LEARNERS: Mapping[str, Callable[..., AnyLearner]] = MappingProxyType({"double-dqn": Learner, "pqn": PQNLearner})
"""The learner of each algorithm."""


def make_learner(
    method: Method, scenario: Scenario, seeds: Sequence[int], world_seeds: npt.NDArray[np.uint64]
) -> AnyLearner:
    """Return the learner of the method's algorithm; see `Learner` for the arguments."""
    return LEARNERS[method.algorithm](method, scenario, seeds, world_seeds)
