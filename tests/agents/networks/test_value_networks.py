from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch

from hhrl_agents import METHODS
from hhrl_agents.methods.configs import DoubleDQNConfig
from hhrl_agents.networks.attention import one_hot
from hhrl_agents.networks.mlp import MLP, Shapes, mlp_shapes, subset
from hhrl_agents.networks.parameters import ParameterStack
from hhrl_agents.networks.value_networks import (
    ActionNetwork,
    frozen_shapes,
    mask_penalty,
    method_shapes,
)
from hhrl_agents.seeding import Purpose, generators
from hhrl_envs.observation import D_D, SIZE
from support import plain_networks

SEEDS = (3, 8, 5)
READINGS = pytest.mark.parametrize(
    ("attention", "config"),
    [
        (False, {}),
        (True, {}),
        (True, {"attended": "linear"}),
        (False, {"layer_norm": True}),
        (True, {"attended": "linear", "layer_norm": True}),
        (False, {"memory": (0.5,)}),
        (True, {"memory": (0.1, 0.03)}),
        (True, {"memory": (0.1,), "layer_norm": True, "sees_line": False}),
        (True, {"sees_line": False}),
        (False, {"sees_line": False}),
    ],
)


def make(*, attention: bool, **config: Any) -> tuple[ParameterStack, ActionNetwork]:
    shapes = ActionNetwork.shapes(features_of(config), (16, 12), 6, attention=attention)
    stack = ParameterStack(shapes, generators(SEEDS, Purpose.INITIALISATION), torch.device("cpu"))
    noise = np.random.default_rng(1).normal(0.0, 0.2, tuple(stack.flat.shape))
    stack.flat.add_(torch.from_numpy(noise.astype(np.float32)))
    return stack, ActionNetwork(stack.online, DoubleDQNConfig(**config))


def features_of(config: dict[str, Any]) -> int:
    return SIZE * (1 + len(config.get("memory", ())))


def batch(size: int = 9, features: int = SIZE) -> tuple[torch.Tensor, torch.Tensor]:
    """States [E, features, K] and one-hot options [E, 2, K]."""
    rng = np.random.default_rng(0)
    states = torch.from_numpy(rng.normal(size=(len(SEEDS), features, size)).astype(np.float32))
    return states, one_hot(torch.from_numpy(rng.integers(0, 2, (len(SEEDS), 1, size))))


def reading(config: dict[str, Any]) -> dict[str, Any]:
    """What the plain networks have to know of the config; they see the traces in the states."""
    return {name: value for name, value in config.items() if name != "memory"}


@READINGS
def test_action_network_is_figure_2(attention: bool, config: dict[str, Any]) -> None:
    stack, network = make(attention=attention, **config)
    states, options = batch(features=features_of(config))
    values = network(states, options)
    assert values.shape == (len(SEEDS), 6, 9)
    for e in range(len(SEEDS)):
        s, o = plain_networks.rows(states, e), plain_networks.rows(options, e)
        leaves = plain_networks.leaves(stack.online, e)
        expected = plain_networks.action_values(leaves, s, o, **reading(config)).detach()
        np.testing.assert_allclose(values[e].T, expected, rtol=1e-4, atol=1e-5)


@READINGS
@pytest.mark.parametrize("part", [slice(0, 9), slice(3, 7)])
def test_gradients_are_those_of_automatic_differentiation(attention: bool, config: dict[str, Any], part: slice) -> None:
    stack, network = make(attention=attention, **config)
    states, options = batch(features=features_of(config))
    slope = torch.from_numpy(np.random.default_rng(2).normal(size=(len(SEEDS), 6, 9)).astype(np.float32))
    _, kept = network.forward(states, options)
    network.backward(kept.columns(part), slope[..., part].contiguous(), stack.gradients)
    for e in range(len(SEEDS)):
        leaves = plain_networks.leaves(stack.online, e)
        values = plain_networks.action_values(
            leaves, plain_networks.rows(states, e), plain_networks.rows(options, e), **reading(config)
        )
        loss = (values * plain_networks.rows(slope, e))[part].sum()
        for name, expected in plain_networks.gradients(loss, leaves).items():
            ours = stack.gradients[name][e]
            np.testing.assert_allclose(ours, expected, rtol=1e-3, atol=1e-4, err_msg=name)
            assert ours.any()


@pytest.mark.parametrize("attention", [False, True])
@pytest.mark.parametrize("memory", [(), (0.1, 0.03)])
def test_values_without_the_line_depend_on_no_element_of_it(attention: bool, memory: tuple[float, ...]) -> None:
    blind = make(attention=attention, memory=memory, sees_line=False)[1]
    seeing = make(attention=attention, memory=memory)[1]
    states, options = batch(features=features_of({"memory": memory}))
    before = states.clone()
    for element in range(states.shape[1]):
        moved = states.clone()
        moved[:, element] += 5.0
        of_the_line = element % SIZE >= D_D
        assert torch.equal(blind(moved, options), blind(states, options)) == of_the_line
        assert not torch.equal(seeing(moved, options), seeing(states, options))
        if attention and not memory:
            assert torch.equal(blind.attention(moved, options), blind.attention(states, options)) == of_the_line
    assert torch.equal(states, before)


def test_attention_is_that_of_the_state_and_weighs_every_trace_of_an_element() -> None:
    stack, network = make(attention=True, memory=(0.1, 0.03))
    states, options = batch(features=3 * SIZE)
    elsewhere = states.clone()
    elsewhere[:, SIZE:] += 1.0
    weights = network.attention(states, options)
    assert weights.shape == (len(SEEDS), SIZE, states.shape[2])
    assert torch.equal(weights, network.attention(elsewhere, options))
    assert torch.equal(weights, network.attention(states[:, :SIZE], options))
    weighed = torch.cat([SIZE * weights * states[:, group * SIZE : (group + 1) * SIZE] for group in range(3)], 1)
    plain = MLP(subset(stack.online, "values."))(torch.cat((weighed, options), 1))
    np.testing.assert_allclose(network(states, options), plain, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("attended", ["state", "linear"])
def test_attention_weighs_the_state_elements_of_the_option(attended: str) -> None:
    stack, network = make(attention=True, attended=attended)
    states, options = batch()
    weights = network.attention(states, options)
    assert weights.shape == states.shape
    assert (weights > 0).all()
    np.testing.assert_allclose(weights.sum(1), 1.0, rtol=1e-5)
    assert (weights - network.attention(states, 1 - options)).abs().max() > 1e-3
    for e in range(len(SEEDS)):
        leaves = plain_networks.leaves(stack.online, e)
        expected = plain_networks.attention(
            leaves, plain_networks.rows(states, e), plain_networks.rows(options, e)
        ).detach()
        np.testing.assert_allclose(weights[e].T, expected, atol=1e-6)


def test_without_attention_every_element_weighs_the_same() -> None:
    _, network = make(attention=False)
    states, options = batch()
    assert torch.equal(network.attention(states, options), torch.full_like(states, 1 / SIZE))


def test_uniform_attention_leaves_the_state_as_it_is() -> None:
    stack, network = make(attention=True)
    states, options = batch()
    for value in subset(stack.online, "attention.").values():
        value.zero_()
    plain = MLP(subset(stack.online, "values."))(torch.cat((states, options), 1))
    np.testing.assert_allclose(network(states, options), plain, atol=1e-5)


def test_subset_takes_the_prefix_off() -> None:
    one, two = torch.zeros(1), torch.ones(1)
    assert subset({"a.b": one, "c.a.b": two}, "a.") == {"b": one}


def test_one_hot_marks_the_option_and_nothing_for_none() -> None:
    assert one_hot(torch.tensor([[[0, 1, -1]]])).tolist() == [[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]


def test_a_masked_option_is_never_the_best() -> None:
    values = torch.tensor([[[5.0], [-3.0]]])
    assert (values + mask_penalty((True, True))).argmax(1).item() == 0
    assert (values + mask_penalty((False, True))).argmax(1).item() == 1


@pytest.mark.parametrize("name", METHODS)
def test_levels_of_the_methods(name: str) -> None:
    method = replace(METHODS[name], config=replace(METHODS[name].config, hidden=(7,)))
    features = SIZE * (1 + len(method.config.memory))
    expected: Shapes = {}
    if "option" in method.levels:
        expected |= {f"option.{key}": shape for key, shape in mlp_shapes(features, 7, 2).items()}
    if "action" in method.levels and method.hierarchical:
        layers = mlp_shapes(features + 2, 7, 6)
        expected |= {f"action.values.{key}": shape for key, shape in layers.items()}
    elif "action" in method.levels:
        expected |= {f"action.{key}": shape for key, shape in mlp_shapes(features, 7, 6).items()}
    if method.attention:
        expected["action.attention.state.weight"] = (SIZE, SIZE)
        expected["action.attention.state.bias"] = (1, SIZE)
        expected["action.attention.option.weight"] = (2, SIZE)
    assert list(method_shapes(method, 6).items()) == list(expected.items())


def test_a_frozen_follower_brings_its_own_shapes() -> None:
    follower = method_shapes(METHODS["follow-only"], 6)
    frozen = frozen_shapes(METHODS["option-only"], 6)
    assert frozen == {f"ffv.{name}": shape for name, shape in follower.items()}
    assert not frozen_shapes(METHODS["hybrid-hrl"], 6)
