"""What an agent is: batches of observations in, batches of decisions out."""

from typing import NamedTuple, Protocol, runtime_checkable

from hhrl_envs import Simulator
from hhrl_envs.arrays import Flags, Floats32, Ints

NO_OPTION = NO_ACTION = -1


class Decision(NamedTuple):
    """One decision for each of B rows.

    option: int64 [B], an `hhrl_envs.Option`, or `NO_OPTION` (-1) from a flat agent.
    action: int64 [B], an index into `scenario.vehicle.levels`.
    """

    option: Ints
    action: Ints


@runtime_checkable
class Agent(Protocol):
    """A behaviour policy for a batch of independent rows."""

    def reset(self, mask: Flags) -> None:
        """Forget what is remembered of the rows that start a new episode (mask, bool [B]).

        The caller resets all rows before the first `act`, and when B changes.
        """

    def act(self, observations: Floats32) -> Decision:
        """Return the option and the action of every row for `observations`, float32 [B, elements].

        Whoever scores an agent takes an array of actions alone, int [B], for the decision of a flat one.
        """


@runtime_checkable
class HierarchicalAgent(Agent, Protocol):
    """An agent whose action level can be given the option (sub-goal) to pursue."""

    def act_with_option(self, observations: Floats32, option: Ints) -> Ints:
        """Return the actions, int64 [B], that pursue `option`, int64 [B], at `observations`, float32 [B, elements]."""


@runtime_checkable
class ClairvoyantAgent(Agent, Protocol):
    """An agent that is shown the worlds themselves: it says what is possible, and is no rival of the others."""

    def foresee(self, simulator: Simulator) -> None:
        """Look at the worlds, B rows at the start of their episodes, before the first `act`; leave them as they are."""


LEVELS = ("option", "action")
"""The levels of the hierarchy; a flat learner has the action level alone."""

OPTION, ACTION = range(len(LEVELS))
"""The places of the levels in arrays with an axis of levels."""
