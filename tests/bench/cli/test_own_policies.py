"""Zips of Stable-Baselines3 on the command line: trusted only if that is asked for."""

import json
from pathlib import Path
from typing import Any

import gymnasium
import pytest
import torch

from hhrl_bench.evaluation.factories import TRUST
from support.command_line import invoke

sb3 = pytest.importorskip("stable_baselines3")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, where nothing is trusted yet."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(TRUST, "0")
    return tmp_path


def save(path: Path, **settings: Any) -> None:
    env = gymnasium.make("hhrl_envs/SoloStop-v0")
    sb3.PPO("MlpPolicy", env, policy_kwargs=settings, seed=0, device="cpu").save(path)


def test_a_zip_that_has_to_be_trusted_is_scored_if_it_is(folder: Path) -> None:
    save(folder / "own.zip", activation_fn=torch.nn.Hardtanh)
    command = ("evaluate", "own.zip", "--task", "solo-stop-v0", "--episodes", "3", "--json")
    refused = invoke(*command)
    assert (refused.exit_code, refused.stdout) == (2, "")
    (line,) = refused.stderr.splitlines()
    assert "own.zip would have to be loaded by running code that is in it, as its activation is" in line
    assert "if you trust the file, add --trust" in line
    trusted = invoke(*command, "--trust")
    assert trusted.exit_code == 0, trusted.stderr
    (result,) = json.loads(trusted.stdout)["results"]
    assert (result["agent"], result["kind"], len(result["runs"])) == ("own.zip", "factory", 1)
