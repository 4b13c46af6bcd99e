"""What every learner of stacked seeds has in common: reports, policies, and a state to go on from."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from torch import Tensor

from hhrl_agents.policies.learned_agent import LearnedAgent
from hhrl_envs.arrays import Floats, Ints
from hhrl_envs.state import State


@dataclass(frozen=True)
class Progress:
    """What happened in training since the last report, all counts for each seed.

    Attributes:
        env_steps: environment steps so far.
        updates: gradient steps so far.
        losses: level -> mean loss since the last report, float64 [E]; not a number without a gradient step.
        outcome_counts: training episodes that ended since the last report, int64 [E, 6], by `hhrl_envs.Outcome`.
        diverged: index of a seed -> why the learner thinks that it has diverged.
    """

    env_steps: int
    updates: int
    losses: dict[str, Floats]
    outcome_counts: Ints
    diverged: Mapping[int, str] = field(default_factory=dict)


class TrainableStack(Protocol):
    """Trains E independent seeds of one method at once; `hhrl_agents.algorithms.double_dqn.Learner` is one."""

    @property
    def env_steps(self) -> int:
        """Environment steps so far, each seed's."""

    @property
    def updates(self) -> int:
        """Gradient steps so far, each seed's."""

    def train(self, env_steps: int) -> Iterator[Progress]:
        """Yield reports while training until `env_steps` are done in all, those before a `restore` among them."""

    def policies(self) -> list[LearnedAgent]:
        """Return each seed's policy as it is now, E agents that later training does not change."""

    def state(self) -> State | None:
        """Return all that the training depends on, as it is at a report; None if this learner cannot be saved."""

    def restore(self, state: State) -> None:
        """Return nothing; go on, bit for bit, where a learner made with the same arguments has been at `state`."""


def beyond_bound(values: Mapping[str, Tensor], largest_reward: Floats, gamma: float) -> dict[int, str]:
    """Return the seeds whose values lie beyond max |r| / (1 - gamma), each with the reason in words.

    values: level -> values of a mini-batch, [E, C, M]; largest_reward: max |r| of each seed, float64 [E].
    """
    with np.errstate(divide="ignore"):
        bound = largest_reward / np.float64(1.0 - gamma)
    reached = {level: value.abs().amax((1, 2)).cpu().double().numpy() for level, value in values.items()}
    return {
        int(index): f"its {level} values reach {largest[index]:.3g}, the rewards allow {bound[index]:.3g}"
        for level, largest in reached.items()
        for index in np.flatnonzero(largest > bound)
    }
