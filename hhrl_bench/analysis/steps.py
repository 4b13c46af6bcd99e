"""Every step of test episodes, in the worlds and batches of the evaluation: what an analysis is computed from."""

from dataclasses import dataclass, fields

import numpy as np

from hhrl_agents import Agent
from hhrl_bench.errors import SeedError, UnknownTaskError
from hhrl_bench.evaluation.metrics import of_selected
from hhrl_bench.evaluation.paired_evaluation import BATCH_ROWS, batches, rollout_of_episode
from hhrl_bench.evaluation.results import Update, silent
from hhrl_bench.evaluation.rollout import Rollout
from hhrl_bench.tasks.tasks import AnyTask, Task, get_task
from hhrl_envs import Outcome, get_scenario
from hhrl_envs.arrays import Codes, Flags, Floats, Floats32, Ints, Keys

MAX_EPISODES = 10_000


@dataclass(frozen=True, slots=True, eq=False)
class Steps:
    """The n steps of N episodes, one episode after the other, each in the order of time.

    Attributes:
        episode: which episode a step belongs to, 0 to N - 1, int64 [n].
        observations: what the agent saw before it decided, float32 [n, 11]; see ``hhrl_envs.observation``.
        option: the selected option, -1 from a flat agent, int64 [n].
        action: the chosen level, int64 [n].
        terms: the signed reward terms, float64 [n, 8]; see ``hhrl_envs.simulation.rewards``.
        reward_task: r^task, float64 [n].
        reward_option: r^option of the selected option, NaN where there is none, float64 [n].
        reward_action: r^action of the selected option, NaN where there is none, float64 [n].
        seeds: world seeds, uint64 [N].
        outcomes: how the episodes ended (:class:`hhrl_envs.Outcome`), int8 [N].
    """

    episode: Ints
    observations: Floats32
    option: Ints
    action: Ints
    terms: Floats
    reward_task: Floats
    reward_option: Floats
    reward_action: Floats
    seeds: Keys
    outcomes: Codes

    @property
    def hierarchical(self) -> bool:
        """Whether an option was selected in every step."""
        return bool((self.option >= 0).all())

    def sums(self, values: Floats) -> Floats:
        """Return the episodes' sums of a number of every step, float64 [N], added in the order of time."""
        sums: Floats = np.bincount(self.episode, weights=values, minlength=len(self.seeds)).astype(np.float64)
        return sums


def record_steps(agent: Agent, task: AnyTask, episodes: int, update: Update = silent) -> Steps:
    """Return the steps of the first ``episodes`` test episodes, the same to the last bit as the evaluation's.

    ``update`` hears how many of them are done, batch by batch.

    Raises:
        InputError: for an unknown task, an agent that answers nonsense, or episodes other than 1 to 10,000.
    """
    task = _of_the_ego_alone(task)
    if not 1 <= episodes <= MAX_EPISODES:
        raise SeedError(f"cannot analyse {episodes} episodes, as all steps are kept; ask for 1 to {MAX_EPISODES}")
    scenario, seeds, parts = get_scenario(task.scenario), task.test.take(episodes), []
    for number, batch in enumerate(batches(seeds)):
        wanted = np.arange(BATCH_ROWS) < episodes - number * BATCH_ROWS
        parts.append(_steps(Rollout(agent, scenario, batch), wanted))
        update(min((number + 1) * BATCH_ROWS, episodes), episodes, "")
    return _join(parts)


def record_episode(agent: Agent, task: AnyTask, episode: int) -> Steps:
    """Return the steps of test episode ``episode``, the same to the last bit as the evaluation's.

    Raises:
        InputError: for an unknown task, an agent that answers nonsense, or an episode outside the test set.
    """
    rollout, row = rollout_of_episode(agent, _of_the_ego_alone(task), episode)
    return _steps(rollout, np.arange(BATCH_ROWS) == row)


def _of_the_ego_alone(task: AnyTask) -> Task:
    task = get_task(task)
    if get_scenario(task.scenario).learned_fronts:
        raise UnknownTaskError(f"{task.id} has several agents; analyse one in a task of the ego alone: stop-line-v0")
    return task


def _steps(rollout: Rollout, wanted: Flags) -> Steps:
    """Return the steps of the wanted rows, bool [B], of a rollout."""
    parts, number = [], np.cumsum(wanted) - 1
    for step in rollout:
        rows = np.flatnonzero(wanted & step.running)
        option, results = step.option[rows], step.results
        parts.append(
            {
                "episode": number[rows],
                "observations": step.observations[rows],
                "option": option,
                "action": step.action[rows],
                "terms": results.terms[rows],
                "reward_task": results.rewards[rows],
                "reward_option": of_selected(results.reward_option[rows], option),
                "reward_action": of_selected(results.reward_action[rows], option),
            }
        )
        if not (wanted & (results.outcomes == Outcome.RUNNING)).any():
            break
    order = np.argsort(np.concatenate([part["episode"] for part in parts]), kind="stable")
    steps = {name: np.concatenate([part[name] for part in parts])[order] for name in parts[0]}
    return Steps(**steps, seeds=rollout.seeds[wanted], outcomes=rollout.simulator.outcomes[wanted])


def _join(parts: list[Steps]) -> Steps:
    """Return the steps of several batches, one after the other."""
    joined = {field.name: np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(Steps)}
    firsts = np.cumsum([0, *(len(part.seeds) for part in parts[:-1])])
    joined["episode"] = np.concatenate([part.episode + first for part, first in zip(parts, firsts, strict=True)])
    return Steps(**joined)
