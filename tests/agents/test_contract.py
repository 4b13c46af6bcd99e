"""What every registered method does: it trains on its task, and its checkpoint alone gives the trained agent back."""

import inspect
import pkgutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hhrl_agents import METHODS
from hhrl_agents.agent import NO_OPTION
from hhrl_agents.methods.configs import CONFIGS, LearnerConfig
from hhrl_agents.methods.method import Method
from hhrl_agents.policies import checkpoint_file, checkpoints
from hhrl_agents.training.learner import NOTHING, Learner, make_learner
from hhrl_envs import InputError, Option, Scenario, Simulator, get_scenario
from support.configs import small_methods

SMALL: dict[str, Any] = {
    "hidden": (16, 16),
    "n_envs": 4,
    "batch_size": 20,
    "replay_capacity": 1_000,
    "warmup": 100,
    "rollout_steps": 25,
    "epochs": 2,
    "minibatches": 4,
    "report_every": 100,
}
SMALL_METHODS = small_methods(SMALL)
STEPS = 300
UPDATES = {"double-dqn": (STEPS - 100) // 4, "pqn": STEPS // 100 * 2 * 4, "ppo": STEPS // 100 * 2 * (100 // 20)}
"""How many gradient steps the algorithms that come with the package take; a new one has only to take some."""
LOSSES = {"ppo": {"policy", "value"}}
"""What is reported of algorithms whose losses are not those of the levels that they learn."""


def scenario_of(name: str) -> Scenario:
    return get_scenario("follow-v0" if name == "follow-only" else "stop-line-v0")


def trained(name: str) -> Learner:
    method, worlds = SMALL_METHODS[name], np.arange(4, dtype=np.uint64)
    learner = make_learner(method, scenario_of(name), 5, worlds)
    losses = LOSSES.get(method.algorithm, set(method.levels))
    assert [set(report.losses) for report in learner.train(STEPS)] == [losses] * 3
    return learner


@pytest.mark.parametrize("name", METHODS)
def test_a_method_trains_and_its_checkpoint_is_the_agent(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    learner, again = trained(name), trained(name)
    assert learner.updates == again.updates == UPDATES.get(METHODS[name].algorithm, learner.updates) > 0
    assert learner.env_steps == STEPS
    agent, same, path = learner.policy(), again.policy(), tmp_path / "seed-5.safetensors"
    assert agent.parameters.keys() == same.parameters.keys()
    assert all(np.array_equal(value, same.parameters[key]) for key, value in agent.parameters.items())
    checkpoints.save(path, agent)
    monkeypatch.setattr(checkpoint_file, "SHIPPED", tmp_path / "nowhere")
    loaded = checkpoints.load(path)
    assert loaded.method == agent.method == SMALL_METHODS[name]
    simulator = Simulator(agent.scenario, 9)
    simulator.reset(np.arange(9))
    for _ in range(50):
        ours, theirs = agent.act(simulator.observations), loaded.act(simulator.observations)
        np.testing.assert_array_equal(ours.option, theirs.option)
        np.testing.assert_array_equal(ours.action, theirs.action)
        assert np.isin(ours.option, [*Option] if agent.method.hierarchical else [NO_OPTION]).all()
        assert ((ours.action >= 0) & (ours.action < agent.scenario.num_actions)).all()
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


@pytest.mark.parametrize("config", CONFIGS.values(), ids=CONFIGS)
def test_an_algorithm_names_its_learner(config: type[LearnerConfig]) -> None:
    learner = pkgutil.resolve_name(config.learner)
    assert issubclass(learner, Learner)
    assert inspect.signature(learner) == inspect.signature(make_learner).replace(return_annotation=None)


@pytest.mark.parametrize("name", METHODS)
def test_a_learner_goes_on_from_its_state_or_says_that_it_cannot(name: str) -> None:
    method, worlds = SMALL_METHODS[name], np.arange(4, dtype=np.uint64)
    learner, fresh = (make_learner(method, scenario_of(name), 5, worlds, start=NOTHING) for _ in range(2))
    next(learner.train(STEPS))
    state = learner.state()
    if state is None:
        with pytest.raises(InputError, match="cannot go on from a state"):
            fresh.restore({})
    else:
        fresh.restore(state)
        assert (fresh.env_steps, fresh.updates) == (learner.env_steps, learner.updates)
