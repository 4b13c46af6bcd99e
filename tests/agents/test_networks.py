from dataclasses import replace

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from hhrl_agents import METHODS
from hhrl_agents.networks import MLP, ActionNetwork, level_shapes, mask_penalty, mlp_shapes, one_hot, subset
from hhrl_agents.parameters import ParameterStack
from hhrl_agents.seeding import Purpose, generators
from hhrl_envs.observation import SIZE

SEEDS = (3, 8, 5)
Arrays = dict[str, NDArray[np.float32]]


def arrays(parameters: dict[str, torch.Tensor], seed_index: int) -> Arrays:
    return {name: value[seed_index].detach().numpy() for name, value in parameters.items()}


def mlp(p: Arrays, x: NDArray[np.float32], depth: int = 3, prefix: str = "") -> NDArray[np.float32]:
    """The network of one seed in plain numpy."""
    for layer in range(depth):
        x = x @ p[f"{prefix}{layer}.weight"] + p[f"{prefix}{layer}.bias"]
        x = np.maximum(x, 0) if layer < depth - 1 else x
    return x


def softmax(x: NDArray[np.float32]) -> NDArray[np.float32]:
    powers = np.exp(x - x.max(-1, keepdims=True))
    shares: NDArray[np.float32] = powers / powers.sum(-1, keepdims=True)
    return shares


def action_values(p: Arrays, s: NDArray[np.float32], o: NDArray[np.float32], attention: bool) -> NDArray[np.float32]:
    """Q^a of Figure 2 for one seed in plain numpy."""
    if attention:
        scores = s @ p["attention.state.weight"] + p["attention.state.bias"] + o @ p["attention.option.weight"]
        s = SIZE * softmax(scores) * s
    return mlp(p, np.concatenate((s, o), -1), prefix="values.")


def make(*, attention: bool) -> tuple[ParameterStack, ActionNetwork]:
    shapes = ActionNetwork.shapes((16, 12), 6, attention=attention)
    stack = ParameterStack(shapes, generators(SEEDS, Purpose.INITIALISATION))
    return stack, ActionNetwork(stack.online)


def batch(seeds: int = len(SEEDS), size: int = 9) -> tuple[torch.Tensor, torch.Tensor]:
    rng = np.random.default_rng(0)
    states = torch.from_numpy(rng.normal(size=(seeds, size, SIZE)).astype(np.float32))
    return states, torch.from_numpy(rng.integers(0, 2, (seeds, size)))


def test_mlp_is_each_seed_s_own_network() -> None:
    stack = ParameterStack(mlp_shapes(SIZE, 16, 12, 6), generators(SEEDS, Purpose.INITIALISATION))
    states, _ = batch()
    values = MLP(stack.online)(states).detach().numpy()
    for e in range(len(SEEDS)):
        np.testing.assert_allclose(values[e], mlp(arrays(stack.online, e), states[e].numpy()), atol=1e-5)


@pytest.mark.parametrize("attention", [False, True])
def test_action_network_is_figure_2(attention: bool) -> None:
    stack, network = make(attention=attention)
    states, options = batch()
    values = network(states, one_hot(options)).detach().numpy()
    for e in range(len(SEEDS)):
        s, o = states[e].numpy(), np.eye(2, dtype=np.float32)[options[e]]
        np.testing.assert_allclose(values[e], action_values(arrays(stack.online, e), s, o, attention), atol=1e-5)


def test_attention_weighs_the_state_elements_of_the_option() -> None:
    stack, network = make(attention=True)
    states, options = batch()
    weights = network.attention(states, one_hot(options)).detach()
    assert weights.shape == states.shape
    assert (weights > 0).all()
    np.testing.assert_allclose(weights.sum(-1), 1.0, rtol=1e-5)
    other = network.attention(states, one_hot(1 - options)).detach()
    assert (weights - other).abs().max() > 1e-3
    expected = softmax(
        states[0].numpy() @ stack.online["attention.state.weight"][0].detach().numpy()
        + stack.online["attention.state.bias"][0].detach().numpy()
        + stack.online["attention.option.weight"][0].detach().numpy()[options[0]]
    )
    np.testing.assert_allclose(weights[0], expected, atol=1e-6)


def test_without_attention_every_element_weighs_the_same() -> None:
    _, network = make(attention=False)
    states, options = batch()
    assert torch.equal(network.attention(states, one_hot(options)), torch.full_like(states, 1 / SIZE))


def test_uniform_attention_leaves_the_state_as_it_is() -> None:
    stack, network = make(attention=True)
    states, options = batch()
    with torch.no_grad():
        for value in subset(stack.online, "attention.").values():
            value.zero_()
        plain = MLP(subset(stack.online, "values."))(torch.cat((states, one_hot(options)), -1))
        np.testing.assert_allclose(network(states, one_hot(options)), plain, atol=1e-5)


def test_one_hot_marks_the_option_and_nothing_for_none() -> None:
    assert one_hot(torch.tensor([[0, 1, -1]])).tolist() == [[[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]]


def test_a_masked_option_is_never_the_best() -> None:
    values = torch.tensor([[5.0, -3.0]])
    assert (values + mask_penalty((True, True))).argmax().item() == 0
    assert (values + mask_penalty((False, True))).argmax().item() == 1


def test_levels_of_the_methods() -> None:
    assert list(level_shapes(METHODS["ddqn"], 6)) == ["action"]
    for name, method in METHODS.items():
        if method.hierarchical:
            shapes = level_shapes(replace(method, config=replace(method.config, hidden=(7,))), 6)
            assert list(shapes) == ["option", "action"]
            assert shapes["option"]["1.weight"] == (7, 2)
            assert shapes["action"]["values.1.weight"] == (7, 6)
            assert ("attention.state.weight" in shapes["action"]) == (name in {"hrl-3", "hybrid-hrl"})
