"""Paired evaluation: episode i of a task's test set is the same world for every agent.

Matrix products may differ in the last bit with the batch's shape, so an agent always sees batches of the same number of
rows: the last batch is filled up with its last world, and those extra episodes are dropped.
"""

import numpy as np
from numpy.typing import NDArray

from hhrl_agents import Agent, Decision
from hhrl_bench.episodes import EpisodeRecords, join
from hhrl_bench.players import Player
from hhrl_bench.seeds import UInt64Array
from hhrl_bench.tasks import Task, get_task
from hhrl_envs import Option, Outcome, Scenario, Simulator, get_scenario, rewards

BATCH_ROWS = 500


def evaluate(
    agent: Agent, task: str | Task = "stop-line-v0", episodes: int = 1000, option: Option | None = None
) -> EpisodeRecords:
    """Return the records of the first ``episodes`` test episodes, equal digit for digit on every call.

    Args:
        agent: the agent to play; see :class:`hhrl_agents.Agent`.
        task: a task or its id.
        episodes: how many test episodes to play, at least 1.
        option: hold this option fixed in place of the agent's own choice.

    Raises:
        InputError: for an unknown task, an impossible number of episodes, or an agent that answers nonsense.
    """
    task = get_task(task)
    return play(agent, get_scenario(task.scenario), task.test.take(episodes), option)


def play(
    agent: Agent, scenario: Scenario, seeds: UInt64Array, option: Option | None = None, rows: int = BATCH_ROWS
) -> EpisodeRecords:
    """Return the records of episode 0 of each world in ``seeds`` uint64 [N], played in batches of ``rows``."""
    player = Player(agent, scenario.num_actions, option)
    simulator = Simulator(scenario, rows)
    padded = np.pad(seeds, (0, -len(seeds) % rows), mode="edge")
    return join([_play_batch(player, simulator, batch) for batch in padded.reshape(-1, rows)], len(seeds))


def _play_batch(player: Player, simulator: Simulator, seeds: UInt64Array) -> EpisodeRecords:
    simulator.reset(seeds)
    player.reset(len(seeds))
    totals = _Totals(len(seeds))
    while (running := simulator.outcomes == Outcome.RUNNING).any():
        decision = player.act(simulator.observations)
        simulator.step(decision.action)
        totals.add(simulator, decision, running)
    return totals.records(seeds, simulator)


class _Totals:
    """Sums over the steps of B running episodes."""

    def __init__(self, rows: int) -> None:
        self._rows = np.arange(rows)
        self._task, self._option, self._action, self._unsafe = np.zeros((4, rows))
        self._unsmooth = np.zeros(rows, np.int32)

    def add(self, simulator: Simulator, decision: Decision, running: NDArray[np.bool_]) -> None:
        terms = simulator.terms
        selected = np.maximum(decision.option, 0)
        hierarchical = np.where(decision.option >= 0, 0.0, np.nan)
        self._task += np.where(running, simulator.rewards, 0.0)
        self._option += np.where(running, simulator.reward_option[self._rows, selected] + hierarchical, 0.0)
        self._action += np.where(running, simulator.reward_action[self._rows, selected] + hierarchical, 0.0)
        self._unsmooth += running & (terms[:, rewards.UNSMOOTH] < 0.0)
        self._unsafe -= np.where(running, terms[:, rewards.UNSAFE_SSL] + terms[:, rewards.UNSAFE_FFV], 0.0)

    def records(self, seeds: UInt64Array, simulator: Simulator) -> EpisodeRecords:
        return EpisodeRecords(
            seed=seeds.copy(),
            outcome=simulator.outcomes.astype(np.int8),
            steps=simulator.steps.astype(np.int32),
            return_task=self._task,
            return_option=self._option,
            return_action=self._action,
            unsmooth=self._unsmooth,
            unsafe=self._unsafe,
        )
