"""What every registered method does: it trains on its task, and its checkpoint alone gives the trained agent back."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from hhrl_agents import METHODS, checkpoints, frozen
from hhrl_agents.learners import Learner
from hhrl_agents.methods import Method
from hhrl_envs import Scenario, Simulator, get_scenario

SMALL: dict[str, Any] = {
    "hidden": (16, 16),
    "n_envs": 4,
    "batch_size": 8,
    "replay_capacity": 1_000,
    "warmup": 100,
    "report_every": 100,
}


def small(name: str) -> Method:
    return replace(METHODS[name], config=replace(METHODS[name].config, **SMALL))


def scenario_of(name: str) -> Scenario:
    return get_scenario("follow-v0" if name == "follow-only" else "stop-line-v0")


def trained(name: str) -> Learner:
    learner = Learner(small(name), scenario_of(name), (3, 5), np.arange(8, dtype=np.uint64).reshape(2, 4))
    assert [set(report.losses) for report in learner.train(300)] == [set(METHODS[name].levels)] * 3
    return learner


@pytest.mark.parametrize("name", METHODS)
def test_a_method_trains_and_its_checkpoint_is_the_agent(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    learner, again = trained(name), trained(name)
    assert learner.updates == (300 - 100) // 4
    assert torch.equal(learner.stack.flat, again.stack.flat)
    agent, path = learner.policies()[1], tmp_path / "seed-5.safetensors"
    checkpoints.save(path, agent)
    monkeypatch.setattr(frozen, "SHIPPED", tmp_path / "nowhere")
    loaded = checkpoints.load(path)
    assert loaded.method == agent.method
    simulator = Simulator(learner.scenario, 9)
    simulator.reset(np.arange(9))
    for _ in range(50):
        ours, theirs = agent.act(simulator.observations), loaded.act(simulator.observations)
        np.testing.assert_array_equal(ours.option, theirs.option)
        np.testing.assert_array_equal(ours.action, theirs.action)
        assert np.isin(ours.option, np.arange(2) if agent.method.hierarchical else [-1]).all()
        assert ((ours.action >= 0) & (ours.action < learner.scenario.num_actions)).all()
        simulator.step(ours.action)


@pytest.mark.parametrize("name", METHODS)
def test_a_method_says_in_a_line_what_sets_it_apart(name: str) -> None:
    assert 0 < len(METHODS[name].summary) <= 80
    assert "\n" not in METHODS[name].summary


def test_no_two_methods_are_the_same() -> None:
    assert len({method.config_hash for method in METHODS.values()}) == len(METHODS)


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"option": "rule-9"}, r"option of method 'x' is 'rule-9'; write one of: none, learned, rule-1, "),
        ({"replay": "always"}, r"replay of method 'x' is 'always'; write one of: uniform, "),
        ({"option": "none", "hybrid_reward": True}, r"option of method 'x' is 'none'; write 'learned' or a rule's id"),
        ({"option": "none", "attention": True}, r"option of method 'x' is 'none'; write 'learned' or a rule's id"),
        ({"option": "none", "ffv": METHODS["follow-only"]}, r"option of method 'x' is 'none'; write 'learned' or"),
        ({"option": "rule-4", "ffv": METHODS["follow-only"]}, r"option of method 'x' is 'rule-4'; write 'learned', as"),
        ({"ffv": METHODS["follow-only"], "attention": True}, r"attention of method 'x' is True; write False"),
        ({"ffv": METHODS["follow-only"], "replay": "hierarchical"}, r"is 'hierarchical'; write uniform or prioritised"),
        ({"option": "rule-4", "replay": "hierarchical"}, r"is 'hierarchical'; write uniform or prioritised"),
        ({"ffv": METHODS["ddqn"]}, r"ffv of method 'x' is 'ddqn'; write a method with options"),
        ({"ffv": METHODS["option-only"]}, r"ffv of method 'x' is 'option-only'; write a method with options"),
    ],
)
def test_levels_that_do_not_go_together_are_refused_in_a_line(changes: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint) as error:
        Method("x", **{"option": "learned", **changes})
    assert "\n" not in str(error.value)
