"""The networks in plain torch, float64 and with autograd, to hold what is compiled against."""

from collections.abc import Mapping

import torch
from torch import Tensor
from torch.nn.functional import layer_norm as normalised

from hhrl_envs.arrays import Floats32
from hhrl_envs.observation import D_D, SIZE

Leaves = dict[str, Tensor]


def leaves(parameters: Mapping[str, Floats32]) -> Leaves:
    """Return the parameters, [1, in, out] each, as float64 leaves [in, out] that gradients can be taken by."""
    return {name: torch.from_numpy(value[0]).double().requires_grad_() for name, value in parameters.items()}


def below(parameters: Leaves, prefix: str) -> Leaves:
    """Return the parameters whose names start with `prefix`, the prefix taken off."""
    return {name.removeprefix(prefix): value for name, value in parameters.items() if name.startswith(prefix)}


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
    return mlp(below(parameters, "values."), torch.cat((states, options), -1), layer_norm=layer_norm)
