"""A stronger rule than those of Table I, to measure learned agents against."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from hhrl_agents.agent import Decision, HierarchicalAgent
from hhrl_agents.rules.controllers import ControllerAgent, predict
from hhrl_agents.rules.tuning import PLUS_TUNING, Tuning
from hhrl_envs import Scenario
from hhrl_envs import observation as obs
from hhrl_envs.arrays import Floats, Floats32


class RulePlus(ControllerAgent):
    """A hierarchical agent without memory that pursues whichever sub-goal asks for the lowest acceleration.

    The controllers act on a predicted state, by default that one actuator lag ahead. The agent knows the scenario's
    nominal values alone: vehicle, speed limit, stop zone, d_0, and the range, delay and errors of its sensors.
    """

    def __init__(self, scenario: Scenario, tuning: Tuning = PLUS_TUNING) -> None:
        super().__init__(scenario, tuning)
        sensor = scenario.sensor
        self._ahead = tuning.lags * scenario.vehicle.lag + tuning.delays * (sensor.delay * scenario.dt)
        self._hidden, self._sight = tuning.hidden, float(np.float32(sensor.front_range)) - 2.0 * sensor.noise_distance

    def si_state(self, observations: Floats32) -> Floats:
        """Return the predicted SI state; see `ControllerAgent.si_state`.

        Where no front vehicle is in sight, one drives just out of it, with the `hidden` share of the speed limit.
        """
        state = super().si_state(observations)
        shown = state[:, obs.V_F]
        state[:, obs.V_F] = np.where(state[:, obs.D_F] < self._sight, shown, self._hidden * shown)
        return predict(state, self._ahead)

    def act(self, observations: Floats32) -> Decision:
        """Return the option that asks for the lowest acceleration and its action, int64 [B] each; see `Agent.act`."""
        state = self.si_state(observations)
        wanted = self.wanted(state)
        option = np.where(self.option_mask, wanted, np.inf).argmin(axis=1).astype(np.int64)
        return Decision(option, self.pursue(state, wanted, option))


RULES: Mapping[str, Callable[[Scenario], HierarchicalAgent]] = MappingProxyType({"rule-plus": RulePlus})
