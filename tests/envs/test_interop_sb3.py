"""Stable-Baselines3 learns to stop at the line on the Gymnasium view, far better than chance and any fixed action."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from stable_baselines3 import DQN, PPO
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.env_checker import check_env
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.vec_env import VecEnv, VecNormalize

from hhrl_envs import SCENARIOS, Reward, Road, Scenario, Simulator
from hhrl_envs.gym_env import StopLineEnv

EASY = replace(
    SCENARIOS["solo-stop-v0"],
    id="easy-stop",
    road=Road(speed_limit=8.0, start_distance=(20.0, 30.0), start_speed=(3.0, 6.0), stop_zone=8.0, stop_speed=0.5),
    reward=Reward(sigma_2=0.05, timeout_scale=0.1),
    horizon=200,
)
"""A short way to a large stop zone, so that a few seconds of training are enough."""


def rows(seed: int) -> VecEnv:
    return make_vec_env(lambda: StopLineEnv(EASY), n_envs=8, seed=seed)


def dqn() -> BaseAlgorithm:
    settings: dict[str, Any] = {"learning_rate": 1e-3, "learning_starts": 1000, "target_update_interval": 500}
    exploration: dict[str, Any] = {"exploration_fraction": 0.5, "exploration_final_eps": 0.02}
    net = {"net_arch": [64, 32]}
    model = DQN("MlpPolicy", rows(1), seed=0, train_freq=1, policy_kwargs=net, device="cpu", **settings, **exploration)
    return model.learn(30_000)


def ppo() -> BaseAlgorithm:
    settings: dict[str, Any] = {"n_steps": 256, "batch_size": 128, "n_epochs": 10, "ent_coef": 0.02}
    scaled = VecNormalize(rows(1), norm_obs=False)
    return PPO("MlpPolicy", scaled, seed=0, device="cpu", **settings).learn(24_000)


def mean_return(choose: Any) -> float:
    """The mean return of 100 worlds; ``choose`` gives actions, int [100]."""
    simulator, total = Simulator(EASY, 100), np.zeros(100)
    simulator.reset(np.arange(100) + 1000)
    for _ in range(EASY.horizon):
        simulator.step(choose())
        total += simulator.rewards
    return float(total.mean())


@pytest.fixture(scope="module")
def without_learning() -> float:
    """The best mean return of chance and of holding any one action."""
    rng = np.random.default_rng(0)
    chance = mean_return(lambda: rng.integers(0, EASY.num_actions, 100))
    return max(chance, *(mean_return(lambda held=held: np.full(100, held)) for held in range(EASY.num_actions)))


@pytest.mark.parametrize("train", [dqn, ppo])
def test_it_learns(train: Any, without_learning: float) -> None:
    returns, _ = evaluate_policy(train(), rows(1000), n_eval_episodes=40, deterministic=True)
    assert without_learning < 0.0
    assert np.mean(returns) > 30.0


@pytest.mark.parametrize("scenario", SCENARIOS.values(), ids=lambda scenario: scenario.id)
def test_its_checker_accepts_every_scenario(scenario: Scenario) -> None:
    check_env(StopLineEnv(scenario))
