"""ONNX files: equal to the agents that they are made of, or not written."""

import json
from pathlib import Path

import numpy as np
import onnx
import onnxruntime
import pytest
import torch

from hhrl_agents import Agent, from_onnx
from hhrl_agents.policies.checkpoint_file import METADATA_KEY, SHIPPED
from hhrl_agents.policies.checkpoints import load
from hhrl_agents.policies.learned_agent import LearnedAgent, agent_metadata, make_agent
from hhrl_agents.reference import onnx as subject
from hhrl_agents.reference.conversion import to_module
from hhrl_agents.reference.modules import PolicyModule
from hhrl_envs import get_scenario
from hhrl_envs.errors import InputError
from support.kinds import method_of, parameters_of

MAIN = get_scenario("stop-line-v0")


@pytest.mark.parametrize("method", [folder.name for folder in sorted(SHIPPED.iterdir()) if folder.is_dir()])
def test_shipped_policies_are_equal_in_every_random_state(method: str, tmp_path: Path) -> None:
    checkpoint = min((SHIPPED / method).glob("seed-*.safetensors"))
    parity = subject.export_onnx(checkpoint, tmp_path / "agent.onnx")
    assert parity.states == parity.equal == 4096
    assert parity.difference < 1e-4  # none on some processors


def test_the_file_says_what_it_is_and_nothing_of_where_it_was_made(tmp_path: Path) -> None:
    path, again = tmp_path / "agent.onnx", tmp_path / "again.onnx"
    agent = load(SHIPPED / "hybrid-hrl-plus" / "seed-0.safetensors")
    subject.export_onnx(agent, path)
    subject.export_onnx(agent, again)
    assert path.read_bytes() == again.read_bytes()
    model = onnx.load(path)
    onnx.checker.check_model(model, full_check=True)
    assert [(entry.key, json.loads(entry.value)) for entry in model.metadata_props] == [(METADATA_KEY, agent.metadata)]
    assert b".py" not in path.read_bytes()
    session = onnxruntime.InferenceSession(path)
    assert [(one.name, one.shape, one.type) for one in session.get_inputs()] == [
        ("features", ["batch", agent.method.config.features], "tensor(float)")
    ]
    assert [one.name for one in session.get_outputs()] == ["option_values", "action_values"]
    require_equal_decisions(agent, from_onnx(path, actions=6))


def require_equal_decisions(agent: Agent, other: Agent) -> None:
    """Fail unless two agents decide alike, over steps at which some rows begin an episode."""
    begins, rng = np.ones(64, np.bool_), np.random.default_rng(0)
    for step in range(4):
        observations = rng.normal(size=(64, 11)).astype(np.float32)
        for one in (agent, other):
            one.reset(begins)
        for ours, theirs in zip(agent.act(observations), other.act(observations), strict=True):
            np.testing.assert_array_equal(ours, theirs)
        begins = np.arange(64) % 2 == step % 2


@pytest.mark.parametrize(
    ("kind", "inputs", "outputs"),
    [
        ("rule-option", ["features", "option"], ["action_values"]),
        ("option-only", ["features"], ["option_values"]),
        ("flat-layer-norm-memory", ["features"], ["action_values"]),
    ],
)
def test_the_levels_that_are_learned_are_in_the_file(
    kind: str, inputs: list[str], outputs: list[str], tmp_path: Path
) -> None:
    method = method_of(kind)
    metadata = agent_metadata(method, MAIN, 0, 0, exact=True)
    agent = make_agent(method, MAIN, parameters_of(method, MAIN, seed=0), metadata)
    parity = subject.export_onnx(agent, tmp_path / "agent.onnx")
    assert parity.equal == parity.states
    session = onnxruntime.InferenceSession(tmp_path / "agent.onnx")
    assert [one.name for one in session.get_inputs()] == inputs
    assert [one.name for one in session.get_outputs()] == outputs
    for rows in (1, 5):
        given = {"features": np.zeros((rows, method.config.features), np.float32), "option": np.zeros(rows, np.int64)}
        (values,) = session.run(None, {name: given[name] for name in inputs})
        assert len(values) == rows


def test_an_agent_remembers_what_it_did_before_its_export(tmp_path: Path) -> None:
    agent = load(SHIPPED / "hybrid-hrl-plus" / "seed-0.safetensors")
    agent.act(np.ones((3, 11), np.float32))
    before = {name: value.copy() for name, value in agent.state().items()}
    subject.export_onnx(agent, tmp_path / "agent.onnx")
    assert all(np.array_equal(value, before[name]) for name, value in agent.state().items())


def test_a_file_that_would_differ_is_not_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def wrong(agent: LearnedAgent) -> PolicyModule:
        module = to_module(agent)
        with torch.no_grad():
            module.get_parameter("action.values.2.bias")[0] += 0.5
        return module

    right, path = load(SHIPPED / "hybrid-hrl" / "seed-0.safetensors"), tmp_path / "agent.onnx"
    path.write_text("before")
    monkeypatch.setattr(subject, "to_module", wrong)
    with pytest.raises(InputError, match=r"the ONNX file of method 'hybrid-hrl' would differ from it: \d+ of 4096"):
        subject.export_onnx(right, path)
    assert path.read_text() == "before"
    assert len(list(tmp_path.iterdir())) == 1
