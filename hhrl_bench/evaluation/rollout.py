"""Worlds in which an agent drives its vehicles, and other agents or scripts drive the others."""

import numpy as np

from hhrl_agents import Agent, Decision
from hhrl_agents.agent import IntArray
from hhrl_agents.training.drivers import EGO_ALONE, Drivers
from hhrl_bench.evaluation.guarded_agent import Player
from hhrl_bench.evaluation.loading import LoadedAgent, load_agents
from hhrl_bench.tasks.seeds import UInt64Array
from hhrl_bench.tasks.tasks import Task
from hhrl_envs import Option, Outcome, Scenario, get_scenario


class Stage:
    """``rows`` worlds of one scenario, played side by side by an agent; ``option`` holds its option fixed.

    Attributes:
        simulator: the worlds.
        slots: the vehicles that the agent drives in every row.
        results: what the agent's vehicles got from the last step, [B slots]: those of a row side by side.
    """

    def __init__(
        self, agent: Agent, scenario: Scenario, rows: int, option: Option | None = None, drivers: Drivers = EGO_ALONE
    ) -> None:
        self.simulator = drivers.simulator(scenario, rows)
        self.slots = drivers.slots
        self._drivers, self._player = drivers, Player(agent, scenario.num_actions, option)

    def begin(self, seeds: UInt64Array) -> None:
        """Return nothing; put every row at the start of episode 0 of its seed, uint64 [B]."""
        self.simulator.reset(seeds)
        self._drivers.begin(np.ones(len(seeds), np.bool_))
        self.results = self._drivers.results(self.simulator)
        self._player.reset(np.ones(len(self.results.outcomes), np.bool_))

    def decide(self) -> Decision:
        """Return what the agent decides for its vehicles, [B slots]."""
        return self._player.act(self.results.observations)

    def step(self, decision: Decision) -> IntArray:
        """Return the actions of all vehicles that are driven, [B] or [B, A]; every row has made a step with them."""
        actions = self._drivers.actions(self.simulator, decision.action)
        self.simulator.step(actions)
        self.results = self._drivers.results(self.simulator)
        return actions

    def is_over(self) -> bool:
        """Return whether the episodes of all agents of all rows have ended."""
        return not (self.simulator.agent_outcomes == Outcome.RUNNING).any()


_EGO, _FRONT = 0, 1


def evaluation_drivers(task: Task) -> Drivers:
    """Return who drives when an agent is scored: it is the ego, or all vehicles where the task is shared."""
    opponent = load_opponent(task)
    if opponent is not None:
        return Drivers((_EGO,), {_FRONT: Player(opponent.agent, get_scenario(task.scenario).num_actions)})
    return _all_vehicles(task) if task.shared else EGO_ALONE


def evaluation_slots(task: Task) -> tuple[int, ...]:
    """Return the vehicles that an agent drives when it is scored."""
    return _all_vehicles(task).slots if task.shared else EGO_ALONE.slots


def training_drivers(task: Task) -> Drivers:
    """Return who drives when an agent is trained: it is the front vehicle where the task has an ego to train against.

    Raises:
        InputError: if no such ego comes with the package.
    """
    if task.ego is not None:
        return Drivers((_FRONT,), {_EGO: _load(task.ego, task).agent})
    return _all_vehicles(task) if task.shared else EGO_ALONE


def load_opponent(task: Task) -> LoadedAgent | None:
    """Return the agent that drives the nearest front vehicle of the task, None where that is scripted."""
    return None if task.opponent is None else _load(task.opponent, task)


def _load(source: str, task: Task) -> LoadedAgent:
    return load_agents(source, get_scenario(task.scenario))[0]


def _all_vehicles(task: Task) -> Drivers:
    return Drivers(tuple(range(1 + (get_scenario(task.scenario).learned_fronts or 0))))
