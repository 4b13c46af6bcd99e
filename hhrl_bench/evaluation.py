"""Paired evaluation: episode i of a task's test set is the same world for every agent.

Matrix products may differ in the last bit with the batch's shape, so an agent always sees batches of the same number of
rows: the last batch is filled up with its last world, and those extra episodes are dropped.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hhrl_agents import Agent, Decision
from hhrl_agents.cast import EGO_ALONE, Cast
from hhrl_bench.casting import evaluation_cast
from hhrl_bench.episodes import EpisodeRecords, TrafficRecords, join
from hhrl_bench.seeds import UInt64Array
from hhrl_bench.stage import Stage
from hhrl_bench.tasks import Task, get_task
from hhrl_envs import Option, Outcome, Scenario, get_scenario, rewards
from hhrl_envs.simulator import Results

BATCH_ROWS = 500
_BY_WEIGHT = np.array([Outcome.COLLISION, Outcome.NOT_STOP, Outcome.REAR_ENDED, Outcome.TIMEOUT, Outcome.FOILED])


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
    cast = evaluation_cast(task)
    return play(agent, get_scenario(task.scenario), task.test.take(episodes), option, cast=cast)


def play(
    agent: Agent,
    scenario: Scenario,
    seeds: UInt64Array,
    option: Option | None = None,
    rows: int = BATCH_ROWS,
    cast: Cast = EGO_ALONE,
) -> EpisodeRecords:
    """Return the records of episode 0 of each world in ``seeds`` uint64 [N], played in batches of ``rows``.

    Where the scenario has learned front vehicles they are :class:`TrafficRecords`.
    """
    stage = Stage(agent, scenario, rows, option, cast)
    padded = np.pad(seeds, (0, -len(seeds) % rows), mode="edge")
    return join([_play_batch(stage, batch) for batch in padded.reshape(-1, rows)], len(seeds))


def _play_batch(stage: Stage, seeds: UInt64Array) -> EpisodeRecords:
    stage.begin(seeds)
    totals = _Totals(len(stage.results.outcomes))
    while not stage.is_over():
        running = stage.results.outcomes == Outcome.RUNNING
        decision = stage.decide()
        stage.step(decision)
        totals.add(stage.results, decision, running)
    return totals.records(seeds, stage)


class _Totals:
    """Sums over the steps of the running episodes of B vehicles."""

    def __init__(self, vehicles: int) -> None:
        self._vehicles = np.arange(vehicles)
        self._task, self._option, self._action, self._unsafe = np.zeros((4, vehicles))
        self._unsmooth = np.zeros(vehicles, np.int32)

    def add(self, results: Results, decision: Decision, running: NDArray[np.bool_]) -> None:
        terms = results.terms
        selected = np.maximum(decision.option, 0)
        hierarchical = np.where(decision.option >= 0, 0.0, np.nan)
        self._task += np.where(running, results.rewards, 0.0)
        self._option += np.where(running, results.reward_option[self._vehicles, selected] + hierarchical, 0.0)
        self._action += np.where(running, results.reward_action[self._vehicles, selected] + hierarchical, 0.0)
        self._unsmooth += running & (terms[:, rewards.UNSMOOTH] < 0.0)
        self._unsafe -= np.where(running, terms[:, rewards.UNSAFE_SSL] + terms[:, rewards.UNSAFE_FFV], 0.0)

    def records(self, seeds: UInt64Array, stage: Stage) -> EpisodeRecords:
        simulator = stage.simulator
        outcomes = stage.results.outcomes.reshape(len(seeds), -1)
        first = slice(None, None, outcomes.shape[1])
        common: dict[str, Any] = {
            "seed": seeds.copy(),
            "outcome": _worst(outcomes),
            "steps": simulator.steps.astype(np.int32),
            "return_task": self._task[first],
            "return_option": self._option[first],
            "return_action": self._action[first],
            "unsmooth": self._unsmooth[first],
            "unsafe": self._unsafe[first],
        }
        if not simulator.scenario.learned_fronts:
            return EpisodeRecords(**common)
        return TrafficRecords(**common, feasible=simulator.feasible, outcomes=simulator.agent_outcomes)


def _worst(outcomes: NDArray[np.int8]) -> NDArray[np.int8]:
    """Return the outcome that counts for vehicles with these, int8 [N], [N, slots]: SUCCESS if all have succeeded."""
    found = (outcomes[:, None, :] == _BY_WEIGHT[:, None]).any(axis=2)
    worst = np.where(found.any(axis=1), _BY_WEIGHT[found.argmax(axis=1)], Outcome.SUCCESS)
    return worst.astype(np.int8)
