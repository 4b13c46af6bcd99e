"""RL Zoo trains and evaluates by its command line, with nothing but the environment's id and hyperparameters given."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("rl_zoo3", reason="RL Zoo is not installed; run: make interop")
pytestmark = pytest.mark.filterwarnings("ignore")  # of packages that are not ours

HYPERPARAMETERS = """
hhrl_envs/StopLine-v0:
  n_envs: 4
  n_timesteps: !!float 4000
  policy: MlpPolicy
  n_steps: 64
  batch_size: 64
  n_epochs: 1
"""


def run(folder: Path, *words: str) -> str:
    """What a Python module has printed that ran in the folder; it must have succeeded."""
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-m", *words],
        cwd=folder, env={**os.environ, "CUDA_VISIBLE_DEVICES": ""}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout


def test_rl_zoo_trains_and_evaluates(tmp_path: Path) -> None:
    (tmp_path / "mine.yml").write_text(HYPERPARAMETERS)
    words = "rl_zoo3.train --algo ppo --env hhrl_envs/StopLine-v0 --gym-packages hhrl_envs -conf mine.yml -f logs"
    said = run(tmp_path, *words.split(), "--eval-freq", "1000", "--eval-episodes", "2", "--device", "cpu")
    assert "ep_rew_mean" in said
    assert "success_rate" in said
    assert list(tmp_path.glob("logs/ppo/hhrl_envs-StopLine-v0_1/hhrl_envs-StopLine-v0.zip"))
