from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch

from hhrl_agents import METHODS
from hhrl_agents.double_dqn_config import DoubleDQNConfig
from hhrl_agents.mlp import MLP
from hhrl_agents.networks import ActionNetwork, mask_penalty, method_shapes, one_hot, subset
from hhrl_agents.parameters import ParameterStack
from hhrl_agents.seeding import Purpose, generators
from hhrl_envs.observation import SIZE
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
    ],
)


def make(*, attention: bool, **config: Any) -> tuple[ParameterStack, ActionNetwork]:
    shapes = ActionNetwork.shapes(SIZE, (16, 12), 6, attention=attention)
    stack = ParameterStack(shapes, generators(SEEDS, Purpose.INITIALISATION), torch.device("cpu"))
    noise = np.random.default_rng(1).normal(0.0, 0.2, tuple(stack.flat.shape))
    stack.flat.add_(torch.from_numpy(noise.astype(np.float32)))
    return stack, ActionNetwork(stack.online, DoubleDQNConfig(**config))


def batch(size: int = 9) -> tuple[torch.Tensor, torch.Tensor]:
    """States [E, 11, K] and one-hot options [E, 2, K]."""
    rng = np.random.default_rng(0)
    states = torch.from_numpy(rng.normal(size=(len(SEEDS), SIZE, size)).astype(np.float32))
    return states, one_hot(torch.from_numpy(rng.integers(0, 2, (len(SEEDS), 1, size))))


@READINGS
def test_action_network_is_figure_2(attention: bool, config: dict[str, Any]) -> None:
    stack, network = make(attention=attention, **config)
    states, options = batch()
    values = network(states, options)
    assert values.shape == (len(SEEDS), 6, 9)
    for e in range(len(SEEDS)):
        s, o = plain_networks.rows(states, e), plain_networks.rows(options, e)
        expected = plain_networks.action_values(plain_networks.leaves(stack.online, e), s, o, **config).detach()
        np.testing.assert_allclose(values[e].T, expected, rtol=1e-4, atol=1e-5)


@READINGS
@pytest.mark.parametrize("part", [slice(0, 9), slice(3, 7)])
def test_gradients_are_those_of_automatic_differentiation(attention: bool, config: dict[str, Any], part: slice) -> None:
    stack, network = make(attention=attention, **config)
    states, options = batch()
    slope = torch.from_numpy(np.random.default_rng(2).normal(size=(len(SEEDS), 6, 9)).astype(np.float32))
    _, trace = network.trace(states, options)
    network.backward(trace.columns(part), slope[..., part].contiguous(), stack.gradients)
    for e in range(len(SEEDS)):
        leaves = plain_networks.leaves(stack.online, e)
        values = plain_networks.action_values(
            leaves, plain_networks.rows(states, e), plain_networks.rows(options, e), **config
        )
        loss = (values * plain_networks.rows(slope, e))[part].sum()
        for name, expected in plain_networks.gradients(loss, leaves).items():
            ours = stack.gradients[name][e]
            np.testing.assert_allclose(ours, expected, rtol=1e-3, atol=1e-4, err_msg=name)
            assert ours.any()


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


def test_levels_of_the_methods() -> None:
    assert all(name.startswith("action.") for name in method_shapes(METHODS["ddqn"], 6))
    for name, method in METHODS.items():
        if method.hierarchical:
            shapes = method_shapes(replace(method, config=replace(method.config, hidden=(7,))), 6)
            levels = [parameter.split(".")[0] for parameter in shapes]
            assert levels == sorted(levels, reverse=True)
            assert set(levels) == {"option", "action"}
            assert shapes["option.1.weight"] == (7, 2)
            assert shapes["action.values.1.weight"] == (7, 6)
            assert ("action.attention.state.weight" in shapes) == (name in {"hrl-3", "hybrid-hrl"})
