from dataclasses import replace

import numpy as np
import pytest
import torch

from hhrl_agents import METHODS
from hhrl_agents.training.drivers import Drivers
from hhrl_agents.training.learner import make_learner, require_device
from hhrl_envs import InputError, get_scenario


def test_the_cpu_is_a_device() -> None:
    require_device("cpu")


@pytest.mark.parametrize("device", ["gpu", "cuda:99"])
def test_a_device_that_is_not_there_is_refused_in_a_line(device: str) -> None:
    with pytest.raises(InputError, match=f"device '{device}'; write cpu, or cuda where there is a GPU"):
        require_device(device)


def test_ppo_stays_on_the_cpu(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hhrl_agents.training.learner.require_device", lambda _: None)
    worlds = np.arange(METHODS["ppo"].config.n_envs, dtype=np.uint64)[None]
    with pytest.raises(InputError, match="device is 'cuda'; write cpu"):
        make_learner(METHODS["ppo"], get_scenario("stop-line-v0"), (0,), worlds, device="cuda")


@pytest.mark.parametrize("name", ["pqn", "ppo"])
def test_other_vehicles_than_the_ego_learn_by_double_dqn(name: str) -> None:
    worlds = np.arange(METHODS[name].config.n_envs, dtype=np.uint64)[None]
    with pytest.raises(InputError, match=f"method is '{name}'; write one that learns by Double DQN"):
        make_learner(METHODS[name], get_scenario("platoon-v0"), (0,), worlds, drivers=Drivers((0, 1, 2, 3)))


def test_a_replay_holds_a_step_of_every_vehicle() -> None:
    few = replace(METHODS["ddqn"], config=replace(METHODS["ddqn"].config, warmup=100, replay_capacity=100))
    worlds = np.arange(few.config.n_envs, dtype=np.uint64)[None]
    with pytest.raises(InputError, match="replay_capacity is 100; write at least 128, a step of every vehicle"):
        make_learner(few, get_scenario("platoon-v0"), (0,), worlds, drivers=Drivers((0, 1, 2, 3)))


@pytest.mark.skipif(not torch.cuda.is_available(), reason="no GPU")
@pytest.mark.parametrize("name", ["ddqn", "hybrid-hrl-plus", "pqn"])
def test_the_same_code_learns_on_a_gpu(name: str) -> None:
    method = METHODS[name]
    worlds = np.arange(2 * method.config.n_envs, dtype=np.uint64).reshape(2, -1)
    learner = make_learner(method, get_scenario("stop-line-v0"), (0, 1), worlds, device="cuda")
    reports = list(learner.train(4_000))
    assert learner.updates > 0
    assert all(np.isfinite(loss).all() for loss in reports[-1].losses.values())
