"""What the worlds of a scenario are like, over many of them."""

from dataclasses import replace

import numpy as np

from hhrl_envs.arguments import as_count, as_scenario
from hhrl_envs.scenario import Scenario
from hhrl_envs.simulator import Simulator


def feasible_share(scenario: Scenario | str, worlds: int = 10_000) -> float:
    """Return the share of drawn worlds in which some ego can succeed, of seeds 0, 1, 2, ...

    Scenarios with ``feasible_only`` reject the others at reset; here they count. Front vehicles are scripted.
    """
    simulator = Simulator(replace(as_scenario(scenario), feasible_only=False), as_count(worlds, "worlds"))
    simulator.reset(np.arange(worlds))
    return float(simulator.feasible.mean())
