"""A stronger rule than those of Table I, to measure learned agents against."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from hhrl_agents.agent import Decision, HierarchicalAgent
from hhrl_agents.rules.controllers import PLUS_TUNING, ControllerAgent, Tuning, one_lag_ahead
from hhrl_envs import Scenario
from hhrl_envs.arrays import Floats, Floats32


class RulePlus(ControllerAgent):
    """A hierarchical agent without memory that pursues whichever sub-goal asks for the lowest acceleration.

    The controllers act on the state one actuator lag ahead. The agent knows the scenario's nominal values alone:
    vehicle, speed limit, stop zone and d_0.
    """

    def __init__(self, scenario: Scenario, tuning: Tuning = PLUS_TUNING) -> None:
        super().__init__(scenario, tuning)
        self._lag = scenario.vehicle.lag

    def si_state(self, observations: Floats32) -> Floats:
        """Return the SI state one lag ahead; see `ControllerAgent.si_state`."""
        return one_lag_ahead(super().si_state(observations), self._lag)

    def act(self, observations: Floats32) -> Decision:
        """Return the option that asks for the lowest acceleration and its action, int64 [B] each; see `Agent.act`."""
        wanted = self.wanted(self.si_state(observations))
        option = np.where(self.option_mask, wanted, np.inf).argmin(axis=1).astype(np.int64)
        return Decision(option, self.pursue(wanted, option))


RULES: Mapping[str, Callable[[Scenario], HierarchicalAgent]] = MappingProxyType({"rule-plus": RulePlus})
