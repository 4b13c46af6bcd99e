import numpy as np
import pytest
import torch

from hhrl_agents.networks.architectures import Architecture
from hhrl_agents.networks.mlp import MLP, affine_backward
from hhrl_agents.networks.parameters import ParameterStack
from hhrl_agents.seeding import Purpose, generators
from support import plain_networks

CPU = torch.device("cpu")


def stack_of(first: int, *hidden: int, last: int, seeds: tuple[int, ...] = (3, 6)) -> ParameterStack:
    stack = ParameterStack(Architecture(first, hidden, last).shapes(), generators(seeds, Purpose.INITIALISATION), CPU)
    stack.flat.add_(torch.from_numpy(np.random.default_rng(1).normal(0, 0.1, stack.flat.shape).astype(np.float32)))
    return stack


def columns(*shape: int, seed: int = 0) -> torch.Tensor:
    return torch.from_numpy(np.random.default_rng(seed).normal(size=shape).astype(np.float32))


def numpy_mlp(stack: ParameterStack, seed_index: int, column: np.ndarray, *, layer_norm: bool) -> np.ndarray:
    depth = sum(name.endswith("weight") for name in stack.online)
    for layer in range(depth):
        weight, bias = (stack.online[f"{layer}.{kind}"][seed_index].numpy() for kind in ("weight", "bias"))
        column = weight.T @ column + bias[0]
        if layer < depth - 1:
            if layer_norm:
                column = (column - column.mean()) / np.sqrt(column.var() + 1e-5)
            column = np.maximum(column, 0.0)
    return column


@pytest.mark.parametrize("layer_norm", [False, True])
def test_each_seed_s_columns_go_through_its_own_layers(layer_norm: bool) -> None:
    stack, inputs = stack_of(11, 16, 8, last=3), columns(2, 11, 5)
    outputs = MLP(stack.online, layer_norm=layer_norm)(inputs)
    assert outputs.shape == (2, 3, 5)
    for e in range(2):
        for k in range(5):
            expected = numpy_mlp(stack, e, inputs[e, :, k].numpy(), layer_norm=layer_norm)
            np.testing.assert_allclose(outputs[e, :, k], expected, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("layer_norm", [False, True])
@pytest.mark.parametrize("part", [slice(0, 7), slice(2, 5)])
def test_gradients_are_those_of_automatic_differentiation(layer_norm: bool, part: slice) -> None:
    stack, inputs, outputs_grad = stack_of(11, 16, 8, last=3), columns(2, 11, 7), columns(2, 3, 7, seed=1)
    network = MLP(stack.online, layer_norm=layer_norm)
    _, kept = network.forward(inputs)
    first = network.backward(kept.columns(part), outputs_grad[..., part].contiguous(), stack.gradients)
    for e in range(2):
        leaves = plain_networks.leaves(stack.online, e)
        outputs = plain_networks.mlp(leaves, plain_networks.rows(inputs, e), layer_norm=layer_norm)
        loss = (outputs * plain_networks.rows(outputs_grad, e))[part].sum()
        for name, gradient in plain_networks.gradients(loss, leaves).items():
            np.testing.assert_allclose(stack.gradients[name][e], gradient, rtol=1e-3, atol=1e-5, err_msg=name)
    np.testing.assert_allclose(first.sum(2), stack.gradients["0.bias"][:, 0], rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize(("fan_in", "fan_out"), [(3, 9), (9, 3)])
def test_a_product_s_gradient_is_the_same_either_way_round(fan_in: int, fan_out: int) -> None:
    inputs, grad = columns(2, fan_in, 5), columns(2, fan_out, 5, seed=1)
    weight_grad, bias_grad = torch.zeros(2, fan_in, fan_out), torch.zeros(2, 1, fan_out)
    affine_backward(inputs, grad, weight_grad, bias_grad)
    np.testing.assert_allclose(weight_grad, np.einsum("eik,eok->eio", inputs, grad), rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(bias_grad[:, 0], grad.sum(2), rtol=1e-5, atol=1e-6)
