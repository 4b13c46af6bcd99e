"""Add a rule agent: follow from far away, and stop at the line as soon as the road to it is free.

    hhrl-bench --extension examples/rule_agent.py evaluate rule-4 rule-patient

A rule agent is made for a scenario and decides for a batch of observations: an option and an action for each row.
"""

import numpy as np

from hhrl_agents import Decision, register_rule
from hhrl_envs import Option, Scenario
from hhrl_envs.arrays import Flags, Floats32, Ints
from hhrl_envs.observation import D_D, D_F, V_E, to_si


class Patient:
    """Drive so that a stop with 1 m/s^2 is possible: at the line under SSL, behind the front vehicle under FFV."""

    def __init__(self, scenario: Scenario) -> None:
        self._levels = np.array(scenario.vehicle.levels)

    def reset(self, mask: Flags) -> None:
        """Forget the rows that begin an episode: there is nothing to forget."""

    def act(self, observations: Floats32) -> Decision:
        """Return the option whose target is nearer, and its action, int64 [B] each."""
        state = to_si(observations)
        option = np.where(state[:, D_F] - 4.0 < state[:, D_D], Option.FFV, Option.SSL)
        return Decision(option, self.act_with_option(observations, option))

    def act_with_option(self, observations: Floats32, option: Ints) -> Ints:
        """Return the actions given the options, so that ``--option`` can hold one, int64 [B]."""
        state = to_si(observations)
        free = np.where(option == Option.FFV, state[:, D_F] - 4.0 - state[:, V_E], state[:, D_D] - 1.0)
        wanted = 2.0 * (np.sqrt(2.0 * np.maximum(free, 0.0)) - state[:, V_E])
        nearest: Ints = np.abs(wanted[:, None] - self._levels).argmin(axis=1)
        return nearest


register_rule("rule-patient", Patient)

if __name__ == "__main__":
    from hhrl_bench import evaluate

    print(evaluate(["rule-4", "rule-patient"], "stop-line-v0", episodes=100))
