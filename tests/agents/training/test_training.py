from dataclasses import replace

import numpy as np
import pytest

from hhrl_agents import METHODS
from hhrl_agents.training.drivers import Drivers
from hhrl_agents.training.learner import make_learner
from hhrl_envs import InputError, get_scenario


@pytest.mark.parametrize("name", ["pqn", "ppo"])
def test_other_vehicles_than_the_ego_learn_by_double_dqn(name: str) -> None:
    worlds = np.arange(METHODS[name].config.n_envs, dtype=np.uint64)
    with pytest.raises(InputError, match=f"method is '{name}'; write one that learns by Double DQN"):
        make_learner(METHODS[name], get_scenario("platoon-v0"), 0, worlds, drivers=Drivers((0, 1, 2, 3)))


@pytest.mark.parametrize("name", ["ddqn", "pqn", "ppo"])
def test_every_environment_has_a_world(name: str) -> None:
    n_envs = METHODS[name].config.n_envs
    with pytest.raises(InputError, match=rf"world_seeds have shape \(3,\); write \({n_envs},\)"):
        make_learner(METHODS[name], get_scenario("stop-line-v0"), 0, np.arange(3, dtype=np.uint64))


def test_a_replay_holds_a_step_of_every_vehicle() -> None:
    few = replace(METHODS["ddqn"], config=replace(METHODS["ddqn"].config, warmup=100, replay_capacity=100))
    worlds = np.arange(few.config.n_envs, dtype=np.uint64)
    with pytest.raises(InputError, match="replay_capacity is 100; write at least 128, a step of every vehicle"):
        make_learner(few, get_scenario("platoon-v0"), 0, worlds, drivers=Drivers((0, 1, 2, 3)))
