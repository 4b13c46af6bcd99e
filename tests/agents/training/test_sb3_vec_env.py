"""Stable-Baselines3 and sb3-contrib train on the native vector view; its rows say what single environments say."""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

pytest.importorskip("stable_baselines3", reason="Stable-Baselines3 is not installed")
pytest.importorskip("sb3_contrib", reason="sb3-contrib is not installed")
from sb3_contrib import MaskablePPO
from stable_baselines3 import DQN, PPO
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.vec_env import DummyVecEnv, VecMonitor, VecNormalize

from hhrl_agents.training.sb3_vec_env import StopLineVecEnv
from hhrl_envs import SCENARIOS
from hhrl_envs.views.gym_env import StopLineEnv
from support.driving import random_actions
from support.misuse import refused

SHORT = replace(SCENARIOS["stop-line-noisy-v0"], id="short-v0", horizon=60, feasible_only=False)
"""Most of its episodes end on the time limit, some before."""


def test_its_rows_tell_the_story_of_single_environments() -> None:
    native, single = StopLineVecEnv(3, SHORT), DummyVecEnv([partial(StopLineEnv, SHORT)] * 3)
    for envs in (native, single):
        envs.seed(7)
    assert np.array_equal(native.reset(), single.reset())  # type: ignore[arg-type]
    endings = 0
    for actions in random_actions(4, 500, 3, 6):
        told, expected = native.step(actions), single.step(actions)
        for mine, other in zip(told[:3], expected[:3], strict=True):
            assert np.array_equal(mine, other)  # type: ignore[arg-type]
        for mine, other in zip(told[3], expected[3], strict=True):
            assert {*other} - {*mine} <= {"TimeLimit.truncated"}
            assert all(np.array_equal(mine[name], other[name]) for name in mine)
        endings += int(told[2].sum())
    assert endings > 5


@pytest.mark.parametrize(
    ("method", "settings"),
    [(DQN, {"learning_starts": 200}), (MaskablePPO, {"n_steps": 64, "n_epochs": 2})],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_it_trains(method: Any, settings: dict[str, Any]) -> None:
    envs = VecMonitor(StopLineVecEnv(8, SHORT))
    model = method("MlpPolicy", VecNormalize(envs), seed=0, device="cpu", **settings).learn(1000)
    assert len(model.ep_info_buffer) > 3
    assert len(model.ep_success_buffer) > 3
    returns, lengths = evaluate_policy(model, envs, n_eval_episodes=8, return_episode_rewards=True)
    assert np.isfinite(returns).all()
    assert np.max(lengths) <= SHORT.horizon


def test_continuous_actions() -> None:
    envs = StopLineVecEnv(4, SHORT, continuous_actions=True)
    PPO("MlpPolicy", envs, n_steps=64, n_epochs=1, seed=0, device="cpu").learn(256)


def test_what_rows_share_and_what_each_has() -> None:
    envs = StopLineVecEnv(2, render_mode="rgb_array")
    envs.reset()
    assert envs.get_attr("num_envs") == [2, 2]
    assert np.asarray(envs.env_method("action_masks", indices=[1])).tolist() == [[True] * 6]
    assert [picture.shape for picture in envs.get_images()] == [(240, 960, 3)] * 2
    assert envs.env_is_wrapped(VecMonitor) == [False, False]  # type: ignore[arg-type]
    refused(lambda: envs.set_attr("threads", 2), "threads cannot be set; give it to StopLineVecEnv(...)")
    refused(lambda: envs.env_method("steps"), "method is 'steps'; write 'action_masks' or 'render'")
