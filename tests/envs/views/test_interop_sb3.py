"""Stable-Baselines3 learns to stop at the line on the Gymnasium view, far better than chance and any fixed action."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from stable_baselines3 import DQN, PPO
from stable_baselines3.common.callbacks import EvalCallback, StopTrainingOnRewardThreshold
from stable_baselines3.common.env_checker import check_env
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.vec_env import VecEnv

from hhrl_envs import SCENARIOS, Reward, Road, Scenario, Simulator
from hhrl_envs.views.gym_env import StopLineEnv

EASY = replace(
    SCENARIOS["solo-stop-v0"],
    id="easy-stop",
    road=Road(speed_limit=8.0, start_distance=(20.0, 30.0), start_speed=(3.0, 6.0), stop_zone=6.0, stop_speed=0.5),
    reward=Reward(sigma_2=0.0, timeout_scale=0.1),
    dt=0.5,
    horizon=60,
)
"""A short way to a large stop zone in long steps, so that a few seconds of training are enough."""

DQN_SETTINGS: dict[str, Any] = {
    "gamma": 0.95,
    "learning_rate": 1e-3,
    "learning_starts": 1000,
    "batch_size": 64,
    "train_freq": 1,
    "gradient_steps": 2,
    "target_update_interval": 1000,
    "exploration_fraction": 0.1,
}
PPO_SETTINGS: dict[str, Any] = {"learning_rate": 6e-4, "n_steps": 128, "batch_size": 128, "ent_coef": 0.02}


SOLVED = 40.0
"""A mean return that only stopping in the zone earns: success is worth 49."""


def rows(seed: int) -> VecEnv:
    return make_vec_env(lambda: StopLineEnv(EASY), n_envs=8, seed=seed)


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


@pytest.mark.parametrize(("method", "settings"), [(DQN, DQN_SETTINGS), (PPO, PPO_SETTINGS)], ids=["DQN", "PPO"])
def test_it_learns(method: Any, settings: dict[str, Any], without_learning: float) -> None:
    model = method("MlpPolicy", rows(1), seed=0, device="cpu", **settings)
    solved = StopTrainingOnRewardThreshold(SOLVED, verbose=0)
    model.learn(
        100_000, EvalCallback(rows(500), callback_on_new_best=solved, eval_freq=250, n_eval_episodes=20, verbose=0)
    )
    returns, _ = evaluate_policy(model, rows(1000), n_eval_episodes=40, deterministic=True)
    assert model.num_timesteps < 100_000
    assert np.mean(returns) > without_learning + 10.0


@pytest.mark.parametrize("scenario", SCENARIOS.values(), ids=lambda scenario: scenario.id)
def test_its_checker_accepts_every_scenario(scenario: Scenario) -> None:
    check_env(StopLineEnv(scenario))
