"""SuperSuit turns the PettingZoo view into vector environments, and Stable-Baselines3 trains on them."""

import numpy as np
import pytest
from stable_baselines3 import PPO

from hhrl_envs import SCENARIOS, triad
from hhrl_envs.views.parallel_env import EGO
from hhrl_envs.worlds import platoon_v0, stop_line_v0

supersuit = pytest.importorskip("supersuit", reason="SuperSuit is not installed")


@pytest.mark.parametrize("scenario_id", SCENARIOS)
def test_markov_vector_env_tells_the_same_story(scenario_id: str) -> None:
    env = supersuit.pettingzoo_env_to_vec_env_v1(triad(scenario_id).parallel_env(learned_fronts=0))
    alone = triad(scenario_id).parallel_env(learned_fronts=0)
    observations, _ = env.reset(seed=5)
    assert (observations[0] == alone.reset(seed=5)[0][EGO]).all()
    for action in (5, 5, 3, 0):
        observations, rewards, terminated, truncated, _ = env.step(np.array([action]))
        expected = alone.step({EGO: action})
        assert (observations[0] == expected[0][EGO]).all()
        assert rewards[0] == np.float32(expected[1][EGO])
        assert (bool(terminated[0]), bool(truncated[0])) == (expected[2][EGO], expected[3][EGO])


@pytest.mark.parametrize("scenario_id", ["platoon-v0", "adversary-v0"])
def test_agents_that_have_left_go_black_until_the_last_is_gone(scenario_id: str) -> None:
    env = supersuit.pettingzoo_env_to_vec_env_v1(supersuit.black_death_v3(triad(scenario_id).parallel_env()))
    alone = triad(scenario_id).parallel_env()
    batch, _ = env.reset(seed=5)
    together, _ = alone.reset(seed=5)
    agents = alone.possible_agents
    assert (batch == np.stack([together[agent] for agent in agents])).all()
    seen = set()
    while alone.agents:
        chosen = dict(zip(agents, (2, 5, 4, 5), strict=False))
        batch, rewards, ended, _, _ = env.step(np.array(list(chosen.values())))
        together, earned, _, _, _ = alone.step({agent: chosen[agent] for agent in alone.agents})
        seen.add(len(together))
        for place, agent in enumerate(agents):
            assert (batch[place] == together.get(agent, np.zeros(11))).all()
            assert rewards[place] == np.float32(earned.get(agent, 0.0))
        assert not ended.any()
    assert len(seen) > 1, "nobody left before the others"
    batch, _, ended, _, _ = env.step(np.zeros(len(agents), np.int64))
    together, _ = alone.reset()
    assert ended.all()
    assert (batch == np.stack([together[agent] for agent in agents])).all()


def test_concatenated_copies_are_independent_and_reset_themselves() -> None:
    single = supersuit.pettingzoo_env_to_vec_env_v1(stop_line_v0.parallel_env())
    copies = supersuit.concat_vec_envs_v1(single, 3, num_cpus=1, base_class="gymnasium")
    first, _ = copies.reset(seed=5)
    assert first.shape == (3, 11)
    assert len(np.unique(first, axis=0)) == 3
    endings = 0
    for _ in range(700):
        observations, _, terminated, truncated, _ = copies.step(np.full(3, 5))
        endings += int(terminated.sum() + truncated.sum())
    assert endings > 3
    assert np.isfinite(observations).all()


def test_stable_baselines_trains_on_it() -> None:
    single = supersuit.pettingzoo_env_to_vec_env_v1(stop_line_v0.parallel_env())
    copies = supersuit.concat_vec_envs_v1(single, 2, num_cpus=1, base_class="stable_baselines3")
    model = PPO("MlpPolicy", copies, n_steps=64, batch_size=64, n_epochs=1, device="cpu").learn(256)
    assert model.num_timesteps == 256


def test_the_way_of_pettingzoos_tutorial() -> None:
    env = supersuit.black_death_v3(platoon_v0.parallel_env())
    single = supersuit.pettingzoo_env_to_vec_env_v1(env)
    copies = supersuit.concat_vec_envs_v1(single, 2, num_cpus=1, base_class="stable_baselines3")
    PPO("MlpPolicy", copies, n_steps=256, batch_size=256, n_epochs=1, device="cpu").learn(2048)
