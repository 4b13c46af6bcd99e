"""A PettingZoo wrapper for libraries that want infos of fixed entries and shapes, as TorchRL does."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pettingzoo.utils.env import ParallelEnv
from pettingzoo.utils.wrappers import BaseParallelWrapper

from hhrl_envs.sub_goals import Option, Outcome
from hhrl_envs.views.spaces import Info

Observations = dict[str, NDArray[np.float32]]
_AT_RESET: Info = {
    "reward_option": np.zeros(len(Option)),
    "reward_action": np.zeros(len(Option)),
    "outcome": int(Outcome.RUNNING),
}


class NumericInfos(BaseParallelWrapper[str, NDArray[np.float32], Any]):
    """Keeps the entries of infos that every step has: ``reward_option``, ``reward_action``, [2] each, and ``outcome``.

    They are there at reset too, as zeros and ``Outcome.RUNNING``.
    """

    def __init__(self, env: ParallelEnv[str, NDArray[np.float32], Any]) -> None:
        super().__init__(env)
        self.metadata, self.possible_agents = env.metadata, env.possible_agents

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observations, dict[str, Info]]:
        """Return the first observations and infos of an episode."""
        observations, infos = super().reset(seed, options)
        return observations, {agent: dict(_AT_RESET) for agent in infos}

    def step(
        self, actions: dict[str, Any]
    ) -> tuple[Observations, dict[str, float], dict[str, bool], dict[str, bool], dict[str, Info]]:
        """Return observations, rewards, terminations, truncations and infos of the live agents after one step."""
        observations, rewards, terminations, truncations, infos = super().step(actions)
        numeric = {
            agent: {name: info.get(name, nothing) for name, nothing in _AT_RESET.items()}
            for agent, info in infos.items()
        }
        return observations, rewards, terminations, truncations, numeric
