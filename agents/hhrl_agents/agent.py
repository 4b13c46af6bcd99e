"""What an agent is: batches of observations in, batches of decisions out."""

from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.int64]
Float32Array = npt.NDArray[np.float32]
FloatArray = npt.NDArray[np.float64]

NO_OPTION = NO_ACTION = -1


class Decision(NamedTuple):
    """One decision for each of B rows.

    option: int64 [B], an `hhrl_envs.Option`, or `NO_OPTION` (-1) from a flat agent.
    action: int64 [B], an index into `scenario.vehicle.levels`.
    """

    option: IntArray
    action: IntArray


@runtime_checkable
class Agent(Protocol):
    """A behaviour policy for a batch of independent rows."""

    def reset(self, mask: BoolArray) -> None:
        """Return nothing; forget what is remembered of the rows that start a new episode (mask, bool [B]).

        Called with an all-true mask before the first `act`; a change of B is announced the same way.
        """

    def act(self, observations: Float32Array) -> Decision:
        """Return the option and the action of every row for `observations`, float32 [B, 11]."""


@runtime_checkable
class HierarchicalAgent(Agent, Protocol):
    """An agent whose action level can be given the option (sub-goal) to pursue."""

    def act_with_option(self, observations: Float32Array, option: IntArray) -> IntArray:
        """Return the actions, int64 [B], that pursue `option`, int64 [B], at `observations`, float32 [B, 11]."""


OPTION, ACTION = range(2)
"""The levels of the hierarchy; a flat learner has the action level alone."""
