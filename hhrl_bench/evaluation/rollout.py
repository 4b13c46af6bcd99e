"""The rollout: an agent drives vehicles of many worlds, step by step; whoever wants to know something adds it up."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hhrl_agents import Agent
from hhrl_agents.training.drivers import EGO_ALONE, Drivers
from hhrl_bench.evaluation.guarded_agent import GuardedAgent
from hhrl_envs import Option, Outcome, Scenario, Simulator
from hhrl_envs.arrays import Flags, Floats, Floats32, Ints, Keys
from hhrl_envs.simulation.simulator import Results

_RUNNING = int(Outcome.RUNNING)  # a plain integer, which numpy compares with quickly


@dataclass(frozen=True)
class Step:
    """A step of B worlds, in which an agent drives V vehicles, as many in every world; those of a world side by side.

    Attributes:
        observations: what the agent saw before it decided, float32 [V, 11]; see ``hhrl_envs.observation``.
        option: the selected options, -1 from a flat agent, int64 [V].
        action: the chosen levels, int64 [V].
        driven: the levels of all vehicles that any agent drives, int64 [B], or [B, A] where they are several.
        running: whose episode was running before the step, bool [V].
        results: what the vehicles got from the step, [V] each: rewards, terms, outcomes, observations after it.
        simulator: the worlds after the step.
        slots: the vehicles that the agent drives in every world; 0 is the ego.
    """

    observations: Floats32
    option: Ints
    action: Ints
    driven: Ints
    running: Flags
    results: Results
    simulator: Simulator
    slots: tuple[int, ...]

    @cached_property
    def first(self) -> "Step":
        """The same step with the first vehicle of every world alone, [B] each."""
        if len(self.slots) == 1:
            return self
        rows = slice(None, None, len(self.slots))
        return Step(
            self.observations[rows],
            self.option[rows],
            self.action[rows],
            self.driven,
            self.running[rows],
            Results._make(values[rows] for values in self.results),
            self.simulator,
            self.slots[:1],
        )

    @cached_property
    def gap(self) -> Floats:
        """The true free road [m] from the first vehicle to the one ahead, float64 [B]; NaN out of sensor range."""
        gap = np.maximum(self._ahead[0], 0.0)
        return np.where(gap < self.simulator.scenario.sensor.front_range, gap, np.nan)

    @property
    def closing(self) -> Floats:
        """How fast that road closes [m/s], float64 [B], whatever its length."""
        return self._ahead[1]

    @cached_property
    def time_to_collision(self) -> Floats:
        """The free road over the closing speed [s], float64 [B]; NaN where it does not close, or is out of range."""
        gap, closing = self.gap, self.closing
        return np.divide(gap, closing, out=np.full_like(gap, np.nan), where=closing > 0.0)

    @cached_property
    def _ahead(self) -> tuple[Floats, Floats]:
        return self.simulator.ahead(self.slots[0])


class Rollout:
    """Episode 0 of B worlds, run side by side from their start until all episodes have ended: iterate over its steps.

    Attributes:
        simulator: the worlds as they are now; at the start, before the first step.
        seeds: those of the worlds, uint64 [B].
        slots: the vehicles that the agent drives in every world.
    """

    def __init__(
        self,
        agent: Agent,
        scenario: Scenario,
        seeds: Keys,
        option: Option | None = None,
        drivers: Drivers = EGO_ALONE,
    ) -> None:
        """Put B worlds at their start; ``option`` holds the agent's option fixed, ``drivers`` drive the vehicles."""
        self.seeds, self.slots = seeds, drivers.slots
        self.simulator = drivers.simulator(scenario, len(seeds))
        self._agent, self._drivers = GuardedAgent(agent, scenario.num_actions, option), drivers
        self.simulator.reset(seeds)
        drivers.begin(np.ones(len(seeds), np.bool_))
        self._agent.foresee(self.simulator)
        self._agent.reset(np.ones(len(seeds) * len(drivers.slots), np.bool_))

    def __iter__(self) -> Iterator[Step]:
        """Yield every step, of all worlds at once; ended episodes stay as they are, and earn nothing."""
        simulator, drivers = self.simulator, self._drivers
        results = drivers.results(simulator)
        while (simulator.agent_outcomes == _RUNNING).any():
            before, running = results.observations, results.outcomes == _RUNNING
            decision = self._agent.act(before)
            driven = drivers.actions(simulator, decision.action)
            simulator.step(driven)
            results = drivers.results(simulator)
            yield Step(before, decision.option, decision.action, driven, running, results, simulator, self.slots)
