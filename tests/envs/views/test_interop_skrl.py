"""skrl wraps the Gymnasium, the native vector and the PettingZoo view, and steps them past many ends."""

from typing import Any

import gymnasium
import pytest

from hhrl_envs import platoon_v0

pytest.importorskip("skrl", reason="skrl is not installed; run: make interop")
import torch
from skrl.envs.wrappers.torch import wrap_env

pytestmark = pytest.mark.filterwarnings("ignore")  # of packages that are not ours
ENV_ID = "hhrl_envs:hhrl_envs/StopLine-v0"


def test_a_single_environment() -> None:
    env: Any = wrap_env(gymnasium.make(ENV_ID), verbose=False)
    ends = 0
    env.reset()
    while ends < 5:
        seen, reward, terminated, truncated, _ = env.step(torch.tensor([[5]]))
        assert seen.shape == (1, 11)
        assert torch.isfinite(reward).all()
        if terminated.any() or truncated.any():
            ends += 1
            env.reset()


@pytest.mark.parametrize("mode", ["vector_entry_point", "sync"])
def test_vector_environments(mode: Any) -> None:
    env: Any = wrap_env(gymnasium.make_vec(ENV_ID, 4, vectorization_mode=mode), verbose=False)
    env.reset()
    ends = 0
    for _ in range(500):
        seen, _, terminated, truncated, infos = env.step(torch.full((4, 1), 5))
        ends += int(terminated.sum() + truncated.sum())
    assert seen.shape == (4, 11)
    assert infos["reward_option"].shape == (4, 2)
    assert ends > 10


def test_several_agents() -> None:
    env: Any = wrap_env(platoon_v0.parallel_env(), verbose=False)
    episodes = 0
    while episodes < 3:
        env.reset()
        while env.agents:
            actions = {agent: torch.tensor([[5]]) for agent in env.possible_agents}
            _, rewards, *_ = env.step(actions)
            assert all(torch.isfinite(reward).all() for reward in rewards.values())
        episodes += 1
    assert set(env.observation_spaces) == set(env.possible_agents)
