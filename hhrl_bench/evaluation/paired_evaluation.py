"""Paired evaluation: episode i of a task's test set is the same world for every agent.

Our own agents decide the same to the last bit in any batch. Another agent's matrix products may differ in the last bit
with the batch's shape, so it always sees batches of the same number of rows: the last batch is filled up with its last
world, and those extra episodes are dropped.
"""

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from hhrl_agents import Agent
from hhrl_agents.policies.learned_agent import LearnedAgent
from hhrl_agents.training.drivers import EGO_ALONE, Drivers
from hhrl_bench.errors import SeedError
from hhrl_bench.evaluation import decisions, episodes
from hhrl_bench.evaluation.decisions import Recorder, Trace
from hhrl_bench.evaluation.episodes import EpisodeRecords, Totals
from hhrl_bench.evaluation.guarded_agent import GuardedAgent
from hhrl_bench.evaluation.loading import LoadedAgent, load_agents
from hhrl_bench.evaluation.metrics import Metric
from hhrl_bench.evaluation.rollout import Rollout
from hhrl_bench.tasks.tasks import Task
from hhrl_envs import Option, Scenario, get_scenario
from hhrl_envs.arrays import Keys

BATCH_ROWS = 500


class ScoredEpisodes(NamedTuple):
    """N episodes: what they came to, and every decision in them."""

    records: EpisodeRecords
    trace: Trace


def play_task(
    agent: Agent,
    task: Task,
    seeds: Keys,
    option: Option | None = None,
    ended: Callable[[int], object] | None = None,
) -> ScoredEpisodes:
    """Return episode 0 of each world in ``seeds`` uint64 [N], with the vehicles driven as the task is scored.

    ``ended`` hears how many episodes have ended, batch by batch.

    Raises:
        InputError: for an agent that answers nonsense, or a flat one whose ``option`` is to be held.
    """
    return play(agent, get_scenario(task.scenario), seeds, option, drivers=evaluation_drivers(task), ended=ended)


def play(
    agent: Agent,
    scenario: Scenario,
    seeds: Keys,
    option: Option | None = None,
    rows: int = BATCH_ROWS,
    drivers: Drivers = EGO_ALONE,
    metrics: Iterable[Metric] | None = None,
    ended: Callable[[int], object] | None = None,
) -> ScoredEpisodes:
    """Return episode 0 of each world in ``seeds`` uint64 [N], in batches of ``rows``; by default with all metrics.

    ``ended`` hears how many episodes have ended, batch by batch.
    Where the scenario has learned front vehicles the records are ``TrafficRecords``.
    """
    records, traces = [], []
    if isinstance(agent, LearnedAgent) and drivers is EGO_ALONE:
        rows = min(rows, len(seeds))
    for batch in batches(seeds, rows):
        rollout = Rollout(agent, scenario, batch, option, drivers)
        totals, recorder = Totals(rollout, metrics), Recorder()
        for step in rollout:
            totals.add(step)
            recorder.add(step.option, step.driven)
        records.append(totals.records())
        traces.append(recorder.trace(records[-1].steps))
        if ended is not None:
            ended(min(len(records) * rows, len(seeds)))
    return ScoredEpisodes(episodes.join(records, len(seeds)), decisions.join(traces, len(seeds)))


def rollout_of_episode(agent: Agent, task: Task, episode: int, option: Option | None = None) -> tuple[Rollout, int]:
    """Return the rollout of the batch that a test episode is scored in, and its row: the same to the last bit.

    Raises:
        SeedError: if there is no such episode.
    """
    if episode < 0:
        raise SeedError(f"episode is {episode}; write the number of a test episode, 0 or more")
    row = episode % BATCH_ROWS
    seeds = task.test.take(BATCH_ROWS, offset=episode - row)
    return Rollout(agent, get_scenario(task.scenario), seeds, option, evaluation_drivers(task)), row


def batches(seeds: Keys, rows: int = BATCH_ROWS) -> Keys:
    """Return the worlds uint64 [N] as batches [., rows]; the last one is filled up with its last world."""
    return np.pad(seeds, (0, -len(seeds) % rows), mode="edge").reshape(-1, rows)


_EGO, _FRONT = 0, 1


def evaluation_drivers(task: Task) -> Drivers:
    """Return who drives when an agent is scored: it is the ego, or all vehicles where the task is shared."""
    opponent = load_opponent(task)
    if opponent is not None:
        return Drivers((_EGO,), {_FRONT: GuardedAgent(opponent.agent, get_scenario(task.scenario).num_actions)})
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
