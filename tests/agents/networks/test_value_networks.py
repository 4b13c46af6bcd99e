from typing import Any

import numpy as np
import pytest
import torch

from hhrl_agents.methods.configs import DoubleDQNConfig
from hhrl_agents.networks.architectures import Architecture, Attended
from hhrl_agents.networks.attention import one_hot
from hhrl_agents.networks.mlp import MLP, subset
from hhrl_agents.networks.parameters import ParameterStack
from hhrl_agents.networks.value_networks import ActionNetwork, mask_penalty
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
    attended = Attended.STATE if attention else Attended.NOTHING
    network = Architecture(features_of(config), (16, 12), 6, reads_option=True, attended=attended)
    stack = ParameterStack(network.shapes(), generators(SEEDS, Purpose.INITIALISATION), torch.device("cpu"))
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
    assert torch.equal(states, before)


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
