"""The networks of one seed in plain torch, rows instead of columns and float64, to check what is written by hand."""

from collections.abc import Mapping

import torch
from torch import Tensor
from torch.nn.functional import layer_norm as normalised

from hhrl_envs.observation import D_D, SIZE

Leaves = dict[str, Tensor]


def leaves(views: Mapping[str, Tensor], seed_index: int, prefix: str = "") -> Leaves:
    """Return one seed's parameters whose names start with `prefix`, float64 leaves that gradients can be taken by."""
    return {
        name.removeprefix(prefix): value[seed_index].double().clone().requires_grad_()
        for name, value in views.items()
        if name.startswith(prefix)
    }


def rows(columns: Tensor, seed_index: int) -> Tensor:
    """Return one seed's columns [E, features, K] as float64 rows [K, features]."""
    return columns[seed_index].double().T


def gradients(loss: Tensor, parameters: Leaves) -> dict[str, Tensor]:
    """Return the gradient of the loss by every parameter."""
    return dict(zip(parameters, torch.autograd.grad(loss, list(parameters.values())), strict=True))


def mlp(parameters: Leaves, inputs: Tensor, *, layer_norm: bool = False) -> Tensor:
    """Return the outputs [K, out] for inputs [K, in]."""
    depth = sum(name.endswith("weight") for name in parameters)
    for layer in range(depth):
        inputs = inputs @ parameters[f"{layer}.weight"] + parameters[f"{layer}.bias"]
        if layer < depth - 1:
            inputs = normalised(inputs, inputs.shape[1:], eps=1e-5) if layer_norm else inputs
            inputs = inputs.relu()
    return inputs


def attention(parameters: Leaves, states: Tensor, options: Tensor) -> Tensor:
    """Return I(s, o), [K, 11], for states [K, 11 (1 + traces)] and one-hot options [K, 2]; the traces do not count."""
    scores = states[:, :SIZE] @ parameters["attention.state.weight"] + parameters["attention.state.bias"]
    return (scores + options @ parameters["attention.option.weight"]).softmax(-1)


def action_values(
    parameters: Leaves,
    states: Tensor,
    options: Tensor,
    *,
    attended: str = "state",
    layer_norm: bool = False,
    sees_line: bool = True,
) -> Tensor:
    """Return Q^a of Figure 2, [K, A], for states [K, 11 (1 + traces)] and one-hot options [K, 2]."""
    if not sees_line:
        states = torch.where(torch.arange(states.shape[1]) % SIZE < D_D, states, 0.0)
    if "attention.state.weight" in parameters:
        weights = attention(parameters, states, options)
        if attended == "linear":
            states = states @ parameters["attention.state.weight"] + parameters["attention.state.bias"]
        states = SIZE * weights.repeat(1, states.shape[1] // SIZE) * states
    values = {name.removeprefix("values."): value for name, value in parameters.items() if name.startswith("values.")}
    return mlp(values, torch.cat((states, options), -1), layer_norm=layer_norm)
