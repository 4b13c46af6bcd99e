"""Every step of test episodes, in the worlds and batches of the evaluation: what an analysis is computed from."""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from hhrl_agents import Agent
from hhrl_bench.errors import SeedError, UnknownTaskError
from hhrl_bench.evaluation.evaluate import BATCH_ROWS
from hhrl_bench.evaluation.guarded_agent import Player
from hhrl_bench.tasks.seeds import UInt64Array
from hhrl_bench.tasks.tasks import Task, get_task
from hhrl_envs import Outcome, Simulator, get_scenario

MAX_EPISODES = 10_000

BoolArray = NDArray[np.bool_]

IntArray = NDArray[np.int64]

FloatArray = NDArray[np.float64]


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

    episode: IntArray
    observations: NDArray[np.float32]
    option: IntArray
    action: IntArray
    terms: FloatArray
    reward_task: FloatArray
    reward_option: FloatArray
    reward_action: FloatArray
    seeds: UInt64Array
    outcomes: NDArray[np.int8]

    @property
    def hierarchical(self) -> bool:
        """Whether an option was selected in every step."""
        return bool((self.option >= 0).all())

    def sums(self, values: FloatArray) -> FloatArray:
        """Return the episodes' sums of a number of every step, float64 [N], added in the order of time."""
        sums: FloatArray = np.bincount(self.episode, weights=values, minlength=len(self.seeds)).astype(np.float64)
        return sums


def record_steps(agent: Agent, task: str | Task, episodes: int) -> Steps:
    """Return the steps of the first ``episodes`` test episodes, the same to the last bit as the evaluation's.

    Raises:
        InputError: for an unknown task, an agent that answers nonsense, or episodes other than 1 to 10,000.
    """
    task = get_task(task)
    if not 1 <= episodes <= MAX_EPISODES:
        raise SeedError(f"cannot analyse {episodes} episodes, as all steps are kept; ask for 1 to {MAX_EPISODES}")
    seeds = task.test.take(episodes)
    padded = np.pad(seeds, (0, -episodes % BATCH_ROWS), mode="edge")
    wanted = np.arange(len(padded)) < episodes
    player, simulator = _table(agent, task)
    batches = range(0, len(padded), BATCH_ROWS)
    slices = [slice(first, first + BATCH_ROWS) for first in batches]
    return _join([_play(player, simulator, padded[batch], wanted[batch]) for batch in slices])


def record_episode(agent: Agent, task: str | Task, episode: int) -> Steps:
    """Return the steps of test episode ``episode``, the same to the last bit as the evaluation's.

    Raises:
        InputError: for an unknown task, an agent that answers nonsense, or an episode outside the test set.
    """
    task = get_task(task)
    if episode < 0:
        raise SeedError(f"episode is {episode}; write the number of a test episode, 0 or more")
    row = episode % BATCH_ROWS
    seeds = task.test.take(BATCH_ROWS, offset=episode - row)
    return _play(*_table(agent, task), seeds, np.arange(BATCH_ROWS) == row)


def _table(agent: Agent, task: Task) -> tuple[Player, Simulator]:
    scenario = get_scenario(task.scenario)
    if scenario.learned_fronts:
        raise UnknownTaskError(f"{task.id} has several agents; analyse one in a task of the ego alone: stop-line-v0")
    return Player(agent, scenario.num_actions), Simulator(scenario, BATCH_ROWS)


def _play(player: Player, simulator: Simulator, seeds: UInt64Array, wanted: BoolArray) -> Steps:
    """Return the steps of the wanted rows, bool [B], of a batch of the worlds ``seeds`` [B]."""
    simulator.reset(seeds)
    player.reset(np.ones(len(seeds), np.bool_))
    parts = []
    while (live := wanted & (simulator.outcomes == Outcome.RUNNING)).any():
        observations = simulator.observations
        decision = player.act(observations)
        simulator.step(decision.action)
        rows = np.flatnonzero(live)
        option = decision.option[rows]
        selected, missing = np.maximum(option, 0), np.where(option >= 0, 0.0, np.nan)
        parts.append(
            {
                "episode": np.cumsum(wanted)[rows] - 1,
                "observations": observations[rows],
                "option": option,
                "action": decision.action[rows],
                "terms": simulator.terms[rows],
                "reward_task": simulator.rewards[rows],
                "reward_option": simulator.reward_option[rows, selected] + missing,
                "reward_action": simulator.reward_action[rows, selected] + missing,
            }
        )
    order = np.argsort(np.concatenate([part["episode"] for part in parts]), kind="stable")
    steps = {name: np.concatenate([part[name] for part in parts])[order] for name in parts[0]}
    return Steps(**steps, seeds=seeds[wanted], outcomes=simulator.outcomes[wanted])


def _join(parts: list[Steps]) -> Steps:
    """Return the steps of several batches, one after the other."""
    joined = {field.name: np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(Steps)}
    firsts = np.cumsum([0, *(len(part.seeds) for part in parts[:-1])])
    joined["episode"] = np.concatenate([part.episode + first for part, first in zip(parts, firsts, strict=True)])
    return Steps(**joined)
