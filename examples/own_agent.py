"""Bring your own agent: whatever has `reset` and `act` is scored by naming what makes it.

hhrl-bench evaluate rule-plus own_agent:make_agent        # in the folder of this file
"""

import numpy as np

from hhrl_agents import Decision
from hhrl_envs import Scenario
from hhrl_envs.arrays import Flags, Floats32
from hhrl_envs.observation import D_D, D_F, V_E, to_si


class Careful:
    """Never faster than a stop at 0.5 m/s^2 allows, before the line and half a second behind the front vehicle."""

    def __init__(self, scenario: Scenario) -> None:
        self._levels = np.array(scenario.vehicle.levels)

    def reset(self, mask: Flags) -> None:
        """Forget the rows that begin an episode, bool [n]: there is nothing to forget."""

    def act(self, observations: Floats32) -> Decision:
        """Return option -1, as the agent is flat, and the actions, for observations float32 [n, 11]."""
        state = to_si(observations)
        behind = state[:, D_F] - 4.0 - 0.5 * state[:, V_E]
        free = np.maximum(np.minimum(state[:, D_D] - 0.5, behind), 0.0)
        wanted = 2.0 * (np.sqrt(free) - state[:, V_E])
        action = np.abs(wanted[:, None] - self._levels).argmin(axis=1)
        return Decision(option=np.full(len(action), -1), action=action)


make_agent = Careful

if __name__ == "__main__":
    from hhrl_bench import compare, evaluate
    from hhrl_envs import SCENARIOS

    evaluation = evaluate({"careful": Careful(SCENARIOS["stop-line-v0"]), "rule-plus": "rule-plus"}, episodes=100)
    print(evaluation)
    print(evaluation.failures())
    print(compare(evaluation["careful"], evaluation["rule-plus"]))
