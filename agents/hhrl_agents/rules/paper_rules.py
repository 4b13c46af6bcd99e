"""The rule agents of Table I: a hand-written option level over the analytic controllers."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from hhrl_agents.agent import Decision
from hhrl_agents.rules.controllers import ControllerAgent
from hhrl_agents.rules.tuning import PAPER_TUNING
from hhrl_envs import Option, Scenario
from hhrl_envs import observation as obs
from hhrl_envs.arrays import Flags, Floats, Floats32, Ints

FollowRule = Callable[[Floats], Flags]
"""Says for each row of the SI state [B, elements] whether to follow the front vehicle (else: stop at the stop-line)."""


class RuleAgent(ControllerAgent):
    """A hierarchical agent without memory: the rule `follow` selects the option, the analytic controllers act."""

    def __init__(self, scenario: Scenario, follow: FollowRule) -> None:
        super().__init__(scenario, PAPER_TUNING)
        self.follow = follow
        self._available = int(np.argmax(self.option_mask))

    def act(self, observations: Floats32) -> Decision:
        """Return the rule's option and the controller's action, int64 [B] each; see `Agent.act`."""
        state = self.si_state(observations)
        option = self._select(state)
        return Decision(option, self.pursue(state, self.wanted(state), option))

    def select(self, observations: Floats32) -> Ints:
        """Return the rule's option alone, int64 [B], for observations float32 [B, elements]."""
        return self._select(self.si_state(observations))

    def _select(self, state: Floats) -> Ints:
        """Return what the rule selects; where the scenario lacks it, the first option that the scenario has."""
        chosen = np.where(self.follow(state), Option.FFV, Option.SSL).astype(np.int64)
        return np.where(self.option_mask[chosen], chosen, self._available)


def rule_1(scenario: Scenario) -> RuleAgent:
    """Return the agent that always follows the front vehicle."""
    return RuleAgent(scenario, lambda state: np.ones(len(state), dtype=np.bool_))


def rule_2(scenario: Scenario) -> RuleAgent:
    """Return the agent that always stops at the stop-line."""
    return RuleAgent(scenario, lambda state: np.zeros(len(state), dtype=np.bool_))


def rule_3(scenario: Scenario) -> RuleAgent:
    """Return the agent that follows while d_d > d_f + car_length: the front bumper ahead has not reached the line."""
    car_length = scenario.vehicle.length
    return RuleAgent(scenario, lambda state: state[:, obs.D_D] > state[:, obs.D_F] + car_length)


def rule_4(scenario: Scenario) -> RuleAgent:
    """Return the agent that follows while d_d > d_fc: the front vehicle binds before the line (printed: d_f)."""
    return RuleAgent(scenario, lambda state: state[:, obs.D_D] > state[:, obs.D_FC])


def rule_4_literal(scenario: Scenario) -> RuleAgent:
    """Return the agent that follows while d_f > d_fc, as printed: always, because d_fc = d_f - d_fs and d_fs > 0."""
    return RuleAgent(scenario, lambda state: state[:, obs.D_F] > state[:, obs.D_FC])


RULES: Mapping[str, Callable[[Scenario], RuleAgent]] = MappingProxyType(
    {
        "rule-1": rule_1,
        "rule-2": rule_2,
        "rule-3": rule_3,
        "rule-4": rule_4,
        "rule-4-literal": rule_4_literal,
    }
)
"""The constructors of the rules of Table I by their ids."""
