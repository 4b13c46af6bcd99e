"""Methods that learn one level alone: what is given, and checkpoints of both levels; see the reference's tests too."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from hhrl_agents import METHODS, RULES
from hhrl_agents.algorithms.double_dqn import DoubleDQNLearner
from hhrl_agents.policies import checkpoint_file, checkpoints
from hhrl_agents.policies.checkpoints import frozen_parameters
from hhrl_agents.policies.learned_agent import HierarchicalLearnedAgent, make_agent
from hhrl_agents.training.exploration import GREEDY
from hhrl_envs import InputError, Option, Simulator, get_scenario
from hhrl_envs.observation import D_D, SIZE

MAIN = get_scenario("stop-line-v0")
COUNT = 80
Array = NDArray[np.float32]


def learner_of(name: str, seen: Array) -> DoubleDQNLearner:
    """A learner whose vehicles see these states."""
    method = METHODS[name]
    learner = DoubleDQNLearner(method, MAIN, 4, np.arange(method.config.n_envs, dtype=np.uint64))
    learner._environments.features = seen
    return learner


def observations_of(rows: int) -> Array:
    """States of driven worlds, so that rules select either option, float32 [rows, 11]."""
    simulator = Simulator(MAIN, rows)
    simulator.reset(np.arange(rows))
    rng = np.random.default_rng(3)
    for _ in range(60):
        simulator.step(rng.integers(2, MAIN.num_actions, rows))
        simulator.reset_done()
    return simulator.observations.copy()


@pytest.mark.parametrize(("name", "rule"), [("follow-only", "rule-1"), ("rule-option", "rule-4")])
def test_given_options_are_the_rule_s_and_tried_actions_are_kept(name: str, rule: str) -> None:
    observations = observations_of(COUNT)
    tried = np.random.default_rng(0).integers(GREEDY, MAIN.num_actions, COUNT)
    options, actions = learner_of(name, observations)._choose({"action": tried})
    np.testing.assert_array_equal(options, RULES[rule](MAIN).act(observations).option)
    np.testing.assert_array_equal(actions[tried != GREEDY], tried[tried != GREEDY])


def test_given_actions_stop_by_the_controller_and_follow_by_the_trained_policy() -> None:
    observations = observations_of(COUNT)
    tried = np.random.default_rng(0).integers(0, 2, COUNT)
    options, actions = learner_of("option-only", observations)._choose({"option": tried})
    np.testing.assert_array_equal(options, tried)
    stop = RULES["rule-2"](MAIN).act(observations).action
    follower = checkpoints.load(checkpoint_file.SHIPPED / "follow-only" / "seed-0.safetensors")
    assert isinstance(follower, HierarchicalLearnedAgent)
    follow = follower.act_with_option(observations, np.ones(len(observations), np.int64))
    assert (stop != follow).any()
    np.testing.assert_array_equal(actions, np.where(tried == Option.FFV, follow, stop))


def test_a_follower_does_not_see_the_line() -> None:
    method = METHODS["follow-only"]
    seen, elsewhere = observations_of(COUNT), observations_of(COUNT)
    agent = learner_of("follow-only", seen).policy()
    elsewhere[:, D_D:] = np.random.default_rng(0).normal(size=(COUNT, SIZE - D_D))
    np.testing.assert_array_equal(agent.act(seen).action, agent.act(elsewhere).action)
    blind = make_agent(replace(method, config=replace(method.config, sees_line=True)), MAIN, agent.parameters, {})
    assert (blind.act(seen).action != blind.act(elsewhere).action).any()


def test_what_is_given_has_no_attention() -> None:
    agent = learner_of("option-only", observations_of(COUNT)).policy()
    assert isinstance(agent, HierarchicalLearnedAgent)
    with pytest.raises(InputError, match="action level is given"):
        agent.attention(observations_of(3), np.zeros(3, np.int64))


def test_a_missing_follower_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert frozen_parameters(METHODS["hybrid-hrl"]) == {}
    other = replace(METHODS["option-only"], ffv=replace(METHODS["follow-only"], attention=True))
    with pytest.raises(InputError, match="another config; train that again"):
        frozen_parameters(other)
    monkeypatch.setattr(checkpoint_file, "SHIPPED", tmp_path)
    with pytest.raises(InputError, match="no such file"):
        frozen_parameters(METHODS["option-only"])
