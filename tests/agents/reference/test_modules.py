"""The torch modules beside the networks that agents evaluate."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from hhrl_agents.policies.learned_agent import HierarchicalLearnedAgent, make_agent
from hhrl_agents.reference.conversion import to_module
from hhrl_agents.reference.modules import NUM_OPTIONS, ActionNetwork
from hhrl_envs import Option, get_scenario
from hhrl_envs.arrays import Floats32
from hhrl_envs.errors import InputError
from hhrl_envs.observation import SIZE
from support.kinds import KINDS, method_of, parameters_of

MAIN = get_scenario("stop-line-v0")
B = 200


def observations(seed: int = 0) -> Floats32:
    return np.random.default_rng(seed).normal(size=(B, SIZE)).astype(np.float32)


@pytest.mark.parametrize("kind", KINDS)
def test_a_module_decides_as_its_agent_does(kind: str) -> None:
    method = method_of(kind)
    agent = make_agent(method, MAIN, parameters_of(method, MAIN, seed=1), {})
    module, seen = to_module(agent), observations()
    agent.reset(np.ones(B, np.bool_))
    decision = agent.act(seen)
    features = torch.from_numpy(np.tile(seen, 1 + len(method.config.memory)))  # a trace begins at what is seen first
    assert np.array_equal(module.best_options(features), decision.option)
    if "action" in method.levels:
        assert np.array_equal(module.action_values(features).argmax(1), decision.action)
        assert len(np.unique(decision.action)) > 1


@pytest.mark.parametrize("kind", KINDS)
def test_values_are_those_of_the_agent_s_networks(kind: str) -> None:
    method = method_of(kind)
    agent = make_agent(method, MAIN, parameters_of(method, MAIN, seed=2), {})
    features = np.tile(observations(), 1 + len(method.config.memory))
    features += np.random.default_rng(1).normal(size=features.shape).astype(np.float32)
    options = np.random.default_rng(3).integers(0, NUM_OPTIONS, B)
    with torch.no_grad():
        found = to_module(agent)(torch.from_numpy(features), torch.from_numpy(options))
    values = dict(zip(method.levels, found if isinstance(found, tuple) else (found,), strict=True))
    for level, network in agent._networks.items():
        given = (options,) if level == "action" and method.hierarchical else ()
        np.testing.assert_allclose(values[level], network.values(features, *given), rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("kind", ["attention", "figure-2", "blind", "rule-option", "no-attention"])
def test_attention_is_the_agent_s(kind: str) -> None:
    method = method_of(kind)
    agent = make_agent(method, MAIN, parameters_of(method, MAIN, seed=3), {})
    assert isinstance(agent, HierarchicalLearnedAgent)
    features = np.tile(observations(), 1 + len(method.config.memory))
    options = np.arange(B) % NUM_OPTIONS
    one_hot = torch.eye(NUM_OPTIONS)[torch.from_numpy(options)]
    network = to_module(agent).get_submodule("action")
    assert isinstance(network, ActionNetwork)
    with torch.no_grad():
        weights = network.weights(torch.from_numpy(features), one_hot)
    np.testing.assert_allclose(weights, agent.attention(features, options), rtol=1e-4, atol=1e-6)
    np.testing.assert_allclose(weights.sum(1), 1.0, rtol=1e-5)


def test_both_levels_give_the_action_values_of_the_best_option() -> None:
    method = method_of("attention")
    module = to_module(make_agent(method, MAIN, parameters_of(method, MAIN, seed=4), {}))
    features = torch.from_numpy(observations())
    option_values, action_values = module(features)
    assert torch.equal(action_values, module.action_values(features, option_values.argmax(1)))
    assert set(option_values.argmax(1).tolist()) == set(range(NUM_OPTIONS))


def test_an_option_that_the_scenario_lacks_is_never_the_best() -> None:
    alone = replace(MAIN, id="alone", traffic=replace(MAIN.traffic, count_shares=(1.0,)))
    method = method_of("attention")
    module = to_module(make_agent(method, alone, parameters_of(method, alone, seed=4), {}))
    features = torch.from_numpy(observations())
    assert (module.best_options(features) == Option.SSL).all()
    assert (module.option_values(features)[:, Option.FFV] == -torch.inf).all()


def test_a_given_action_level_has_no_values() -> None:
    method = method_of("option-only")
    module = to_module(make_agent(method, MAIN, parameters_of(method, MAIN, seed=5), {}))
    with pytest.raises(InputError, match="'option-only' has no action values: its action level is given"):
        module.action_values(torch.from_numpy(observations()))
    assert not any(value.requires_grad for value in module.get_submodule("ffv").parameters())
