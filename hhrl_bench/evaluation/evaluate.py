"""Paired evaluation: episode i of a task's test set is the same world for every agent.

Matrix products may differ in the last bit with the batch's shape, so an agent always sees batches of the same number of
rows: the last batch is filled up with its last world, and those extra episodes are dropped.
"""

from typing import NamedTuple

import numpy as np

from hhrl_agents import Agent
from hhrl_agents.training.drivers import EGO_ALONE, Drivers
from hhrl_bench.evaluation import decisions, episodes
from hhrl_bench.evaluation.decisions import Recorder, Trace
from hhrl_bench.evaluation.episode_sums import Tally
from hhrl_bench.evaluation.episodes import EpisodeRecords
from hhrl_bench.evaluation.rollout import Stage, evaluation_drivers
from hhrl_bench.tasks.seeds import UInt64Array
from hhrl_bench.tasks.tasks import Task, get_task
from hhrl_envs import Option, Outcome, Scenario, get_scenario

BATCH_ROWS = 500


class Played(NamedTuple):
    """N episodes: what they came to, and every decision in them."""

    records: EpisodeRecords
    trace: Trace


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
    return play_task(agent, task, task.test.take(episodes), option).records


def play_task(agent: Agent, task: Task, seeds: UInt64Array, option: Option | None = None) -> Played:
    """Return episode 0 of each world in ``seeds`` uint64 [N], played as the task is scored."""
    return play(agent, get_scenario(task.scenario), seeds, option, drivers=evaluation_drivers(task))


def play(
    agent: Agent,
    scenario: Scenario,
    seeds: UInt64Array,
    option: Option | None = None,
    rows: int = BATCH_ROWS,
    drivers: Drivers = EGO_ALONE,
) -> Played:
    """Return episode 0 of each world in ``seeds`` uint64 [N], played in batches of ``rows``.

    Where the scenario has learned front vehicles the records are ``TrafficRecords``.
    """
    stage = Stage(agent, scenario, rows, option, drivers)
    padded = np.pad(seeds, (0, -len(seeds) % rows), mode="edge")
    records, trace = zip(*[_play_batch(stage, batch) for batch in padded.reshape(-1, rows)], strict=True)
    return Played(episodes.join(records, len(seeds)), decisions.join(trace, len(seeds)))


def _play_batch(stage: Stage, seeds: UInt64Array) -> Played:
    stage.begin(seeds)
    tally, recorder = Tally(stage), Recorder()
    while not stage.is_over():
        running = stage.results.outcomes == Outcome.RUNNING
        decision = stage.decide()
        recorder.add(decision.option, stage.step(decision))
        tally.add(decision.option, running)
    records = tally.records(seeds)
    return Played(records, recorder.trace(records.steps))
