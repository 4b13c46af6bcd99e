"""Minari records the Gymnasium view, infos and all, past many ends."""

import warnings
from pathlib import Path

import gymnasium
import numpy as np
import pytest

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    minari = pytest.importorskip("minari", reason="Minari is not installed")
    pytest.importorskip("jax", reason="jax is not installed, which Minari needs to record")
pytestmark = pytest.mark.filterwarnings("ignore")  # of packages that are not ours


def test_a_recorded_data_set_holds_what_the_view_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    env = minari.DataCollector(gymnasium.make("hhrl_envs/StopLine-v0"), record_infos=True)
    view, rewards, outcomes = gymnasium.make("hhrl_envs/StopLine-v0"), [], []
    for seed in range(6):
        env.reset(seed=seed)
        view.reset(seed=seed)
        over = False
        while not over:
            env.step(5)
            _, _, terminated, truncated, info = view.step(5)
            over = terminated or truncated
            rewards.append(info["reward_option"])
        outcomes.append(info["outcome"])
    data = env.create_dataset("hhrl/test-v0", algorithm_name="x", author="x", author_email="x@y.z", code_permalink="x")
    assert data.total_episodes == 6
    kept = list(data.iterate_episodes())
    assert [int(episode.infos["outcome"][-1]) for episode in kept] == outcomes
    assert np.array_equal(np.concatenate([episode.infos["reward_option"][1:] for episode in kept]), rewards)
    assert data.recover_environment().spec.id == "hhrl_envs/StopLine-v0"
