"""Value networks for stacked seeds: every layer holds E independent weight matrices, [E, in, out].

Networks are plain functions of a mapping from parameter names to tensors, so that the same code evaluates online and
target parameters, one seed or many.
"""

from collections.abc import Mapping
from itertools import pairwise

import torch
from torch import Tensor

from hhrl_agents.methods import Method
from hhrl_envs import Option
from hhrl_envs.observation import SIZE

Parameters = Mapping[str, Tensor]
Shapes = dict[str, tuple[int, int]]

NUM_OPTIONS = len(Option)
_OPTIONS = torch.arange(NUM_OPTIONS)


def mlp_shapes(*sizes: int) -> Shapes:
    """Return the parameter shapes of fully connected layers with `sizes` units, inputs first; biases are [1, out]."""
    shapes: Shapes = {}
    for layer, (fan_in, fan_out) in enumerate(pairwise(sizes)):
        shapes[f"{layer}.weight"] = (fan_in, fan_out)
        shapes[f"{layer}.bias"] = (1, fan_out)
    return shapes


class MLP:
    """Fully connected layers: ReLU inside, linear at the end."""

    def __init__(self, parameters: Parameters) -> None:
        depth = sum(name.endswith(".weight") for name in parameters)
        layers = [(parameters[f"{layer}.weight"], parameters[f"{layer}.bias"]) for layer in range(depth)]
        self._hidden, self._last = layers[:-1], layers[-1]

    def __call__(self, inputs: Tensor) -> Tensor:
        """Return the last layer's outputs [E, B, out] for inputs [E, B, in]."""
        for weight, bias in self._hidden:
            inputs = torch.baddbmm(bias, inputs, weight).relu_()
        weight, bias = self._last
        return torch.baddbmm(bias, inputs, weight)


class ActionNetwork:
    """Q^a of Figure 2: attention over the state elements given the option, then fully connected layers.

    w = softmax(Linear(s) + Linear(o)) and s^I = 11 w * s, so that uniform attention leaves the state as it is. Without
    attention s^I = s. The layers read s^I beside the one-hot option.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._values = MLP(subset(parameters, "values."))
        self._attention = subset(parameters, "attention.")

    @staticmethod
    def shapes(hidden: tuple[int, ...], num_actions: int, *, attention: bool) -> Shapes:
        """Return the parameter shapes for `hidden` units a layer and `num_actions` outputs."""
        layers = mlp_shapes(SIZE + NUM_OPTIONS, *hidden, num_actions)
        shapes = {f"values.{name}": shape for name, shape in layers.items()}
        if attention:
            shapes["attention.state.weight"] = (SIZE, SIZE)
            shapes["attention.state.bias"] = (1, SIZE)
            shapes["attention.option.weight"] = (NUM_OPTIONS, SIZE)
        return shapes

    def attention(self, states: Tensor, options: Tensor) -> Tensor:
        """Return the attention weights I(s, o), [E, B, 11], each row summing to 1; uniform without attention.

        states: [E, B, 11]; options: one-hot [E, B, 2].
        """
        if not self._attention:
            return torch.full_like(states, 1 / SIZE)
        scores = torch.baddbmm(self._attention["state.bias"], states, self._attention["state.weight"])
        return torch.baddbmm(scores, options, self._attention["option.weight"]).softmax(-1)

    def __call__(self, states: Tensor, options: Tensor) -> Tensor:
        """Return Q^a(s^I, o, .), [E, B, A], for states [E, B, 11] and one-hot options [E, B, 2]."""
        if self._attention:
            states = SIZE * self.attention(states, options) * states
        return self._values(torch.cat((states, options), -1))


def subset(parameters: Parameters, prefix: str) -> dict[str, Tensor]:
    """Return the parameters whose names start with `prefix`, the prefix taken off."""
    return {name.removeprefix(prefix): value for name, value in parameters.items() if name.startswith(prefix)}


def level_shapes(method: Method, num_actions: int) -> dict[str, Shapes]:
    """Return the parameter shapes of each level's network: `option` and `action`; a flat method has `action` alone."""
    hidden = method.config.hidden
    if not method.hierarchical:
        return {"action": mlp_shapes(SIZE, *hidden, num_actions)}
    action = ActionNetwork.shapes(hidden, num_actions, attention=method.attention)
    return {"option": mlp_shapes(SIZE, *hidden, NUM_OPTIONS), "action": action}


def one_hot(options: Tensor) -> Tensor:
    """Return float32 [..., 2] for integer options [...]."""
    return (options.unsqueeze(-1) == _OPTIONS).float()


def mask_penalty(option_mask: tuple[bool, ...]) -> Tensor:
    """Return what to add to option values so that no absent option is the best, float32 [2]: 0 or minus infinity."""
    return torch.where(torch.tensor(option_mask), 0.0, -torch.inf)
