"""Who drives which vehicle of a world with several agents."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from hhrl_agents.agent import Agent
from hhrl_envs import Scenario, Simulator
from hhrl_envs.arrays import Flags, Ints
from hhrl_envs.errors import InputError
from hhrl_envs.simulation.simulator import Results


class Drivers(NamedTuple):
    """The vehicles that one agent drives, all by the same policy, and the agents that drive the others.

    slots: 0 is the ego, k its k-th front vehicle, ascending; others: an agent for every other slot up to the last.
    """

    slots: tuple[int, ...] = (0,)
    others: Mapping[int, Agent] = MappingProxyType({})

    def simulator(self, scenario: Scenario, rows: int) -> Simulator:
        """Return a simulator of so many rows in which an agent drives every vehicle that is named here.

        Raises:
            InputError: if a slot has no driver, or the scenario has no such front vehicle.
        """
        agents = sorted([*self.slots, *self.others])
        if agents != list(range(len(agents))):
            raise InputError(f"an agent drives the vehicles {agents}; name each of 0 to {agents[-1]} once")
        return Simulator(scenario, rows, learned_fronts=len(agents) - 1)

    def results(self, simulator: Simulator) -> Results:
        """Return what the own vehicles got from a step, [B slots] each: those of a row side by side."""
        own = [simulator.of_agent(slot) for slot in self.slots]
        if len(own) == 1:
            return own[0]
        return Results(*(np.stack(parts, axis=1).reshape(-1, *parts[0].shape[1:]) for parts in zip(*own, strict=True)))

    def begin(self, rows: Flags) -> None:
        """Tell the drivers of the other vehicles which rows, bool [B], begin an episode."""
        for agent in self.others.values():
            agent.reset(rows)

    def actions(self, simulator: Simulator, own: Ints) -> Ints:
        """Return what all vehicles do, as `Simulator.step` takes it, given what the own ones do, int64 [B slots]."""
        if simulator.num_agents == 1:
            return own
        actions = np.empty((simulator.num_rows, simulator.num_agents), np.int64)
        actions[:, self.slots] = own.reshape(simulator.num_rows, -1)
        for slot, agent in self.others.items():
            actions[:, slot] = agent.act(simulator.of_agent(slot).observations.copy()).action
        return actions


EGO_ALONE = Drivers()
