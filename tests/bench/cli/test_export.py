"""The command ``export``: what it writes and says, and what it refuses in one line."""

from pathlib import Path

import numpy as np
import onnxruntime
import pytest

from hhrl_agents.policies.checkpoint_file import SHIPPED
from hhrl_bench.evaluation.loading import load_agent
from hhrl_envs.observation import SIZE
from support.command_line import invoke


def test_an_exported_agent_decides_as_it_does_here(tmp_path: Path) -> None:
    path = tmp_path / "new" / "agent.onnx"
    result = invoke("export", "hybrid-hrl", "--onnx", str(path))
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith(f"{path}: option and action values of hybrid-hrl, training seed 0\n")
    assert "decides alike in 4,096 of 4,096 random states (0 ties); values differ by at most" in result.stdout
    assert [one.name for one in path.parent.iterdir()] == ["agent.onnx"]
    states = np.random.default_rng(1).normal(size=(64, SIZE)).astype(np.float32)
    options, actions = onnxruntime.InferenceSession(path).run(None, {"features": states})
    decision = load_agent("hybrid-hrl").act(states)
    assert (options.argmax(1) == decision.option).all()
    assert (actions.argmax(1) == decision.action).all()


def test_one_level_is_said_to_be_one(tmp_path: Path) -> None:
    checkpoint = SHIPPED / "follow-only" / "seed-0.safetensors"
    result = invoke("export", str(checkpoint), "--onnx", str(tmp_path / "agent.onnx"))
    assert result.exit_code == 0, result.output
    assert "action values of follow-only, training seed 0\n" in result.stdout


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("rule-4",), "agent 'rule-4' has no networks to write; name a learned one"),
        (("hybird-hrl",), "unknown agent 'hybird-hrl', did you mean hybrid-hrl"),
        (("pqn",), "no trained pqn comes with the package"),
        (("nowhere.safetensors",), "unknown agent 'nowhere.safetensors'"),
        (("ddqn", "--task", "nothing-v0"), "nothing-v0"),
    ],
)
def test_what_cannot_be_exported_is_refused_in_a_line(
    arguments: tuple[str, ...], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = invoke("export", *arguments, "--onnx", "agent.onnx")
    assert (result.exit_code, result.stdout) == (2, "")
    assert len(result.stderr.splitlines()) == 1
    assert said in result.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("place", [".", "file/agent.onnx"])
def test_a_place_that_cannot_be_written_is_refused_in_a_line(
    place: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("in the way")
    result = invoke("export", "ddqn", "--onnx", place)
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith("hhrl-bench: cannot write ")
    assert len(result.stderr.splitlines()) == 1


def test_the_file_to_write_has_to_be_named() -> None:
    result = invoke("export", "ddqn")
    assert result.exit_code == 2
    assert "--onnx" in result.stderr
