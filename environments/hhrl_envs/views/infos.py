"""What infos hold: entries of an episode's start, and numeric entries that are there at reset and at every step."""

from typing import Any

import numpy as np
from pettingzoo.utils.env import ParallelEnv
from pettingzoo.utils.wrappers import BaseParallelWrapper

from hhrl_envs.arrays import Floats32
from hhrl_envs.simulation.simulator import Simulator
from hhrl_envs.sub_goals import SUB_GOALS, Outcome

Info = dict[str, Any]
Infos = dict[str, Info]


def reset_info(simulator: Simulator, row: int) -> Info:
    """Return a row's info at reset: profiles, the road's friction, feasibility, option mask, (seed, episode_index)."""
    seed, episode = simulator.key(row)
    return {
        "profiles": simulator.profiles(row),
        "friction": float(simulator.friction[row]),
        "feasible": bool(simulator.feasible[row]) if simulator.num_agents == 1 else None,
        "option_mask": np.array(simulator.scenario.option_mask),
        "seed": seed,
        "episode_index": episode,
    }


def running_info() -> Info:
    """Return the numeric entries of an episode that goes on and has not earned anything yet."""
    return {
        "reward_option": np.zeros(len(SUB_GOALS)),
        "reward_action": np.zeros(len(SUB_GOALS)),
        "outcome": int(Outcome.RUNNING),
        "is_success": False,
    }


class NumericInfos(BaseParallelWrapper[str, Floats32, Any]):
    """Keeps numbers in infos: ``reward_option``, ``reward_action``, [K] each, ``outcome`` and ``is_success``.

    They are there at reset too, as zeros, ``Outcome.RUNNING`` and False. It is for libraries that want infos of the
    same entries and shapes at all times, as TorchRL does. `pettingzoo.utils.parallel_to_aec` makes an AEC view of it.
    """

    def __init__(self, env: ParallelEnv[str, Floats32, Any]) -> None:
        super().__init__(env)
        self.metadata, self.possible_agents = env.metadata, env.possible_agents

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Floats32], Infos]:
        """Return the first observations and infos of an episode."""
        observations, infos = super().reset(seed, options)
        return observations, {agent: running_info() for agent in infos}

    def step(
        self, actions: dict[str, Any]
    ) -> tuple[dict[str, Floats32], dict[str, float], dict[str, bool], dict[str, bool], Infos]:
        """Return observations, rewards, terminations, truncations and infos of the live agents after one step."""
        observations, rewards, terminations, truncations, infos = super().step(actions)
        return observations, rewards, terminations, truncations, {agent: _numeric(infos[agent]) for agent in infos}


def _numeric(info: Info) -> Info:
    outcome = int(info.get("outcome", Outcome.RUNNING))
    rewards = {name: info[name] for name in ("reward_option", "reward_action")}
    return {**rewards, "outcome": outcome, "is_success": outcome == Outcome.SUCCESS}
