"""AgileRL steps copies of the PettingZoo view in processes of their own, past many ends."""

from typing import Any

import numpy as np
import pytest

from hhrl_envs import platoon_v0

pytest.importorskip("agilerl", reason="AgileRL is not installed; run: make interop")
from agilerl.vector.pz_async_vec_env import AsyncPettingZooVecEnv

pytestmark = pytest.mark.filterwarnings("ignore")  # of packages that are not ours


def make() -> Any:
    return platoon_v0.parallel_env()


def test_copies_in_processes() -> None:
    envs = AsyncPettingZooVecEnv([make] * 2)
    envs.reset(seed=3)
    ends = 0
    for _ in range(800):
        actions = {agent: np.full(2, 5) for agent in envs.possible_agents}
        observations, rewards, terminations, truncations, _ = envs.step(actions)
        ends += int(np.sum([terminations["ego"], truncations["ego"]]))
    envs.close()
    assert observations["ego"].shape == (2, 11)
    assert np.isfinite(rewards["ego"]).all()
    assert ends > 5
