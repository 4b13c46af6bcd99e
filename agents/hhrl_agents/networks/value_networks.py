"""The value networks of Figure 2 for stacked seeds: option values from states, action values from states and options.

Networks are plain functions of a mapping from parameter names to tensors, so that the same code evaluates online and
target parameters, one seed or many. States are columns, [E, 11, K], and so are values; see `hhrl_agents.networks.mlp`.
"""

from typing import NamedTuple

import torch
from torch import Tensor

from hhrl_agents.methods.configs import DoubleDQNConfig
from hhrl_agents.methods.method import Method
from hhrl_agents.networks.mlp import MLP, Parameters, Shapes, Trace, linear, linear_backward, mlp_shapes
from hhrl_envs import Option
from hhrl_envs.observation import D_D, SIZE

NUM_OPTIONS = len(Option)
FFV = "ffv."
"""What the names of a frozen FFV policy's parameters begin with."""


class ActionTrace(NamedTuple):
    """What a forward pass leaves for `ActionNetwork.backward`: states, one-hot options, attention, s^I, and layers."""

    states: Tensor
    options: Tensor
    weights: Tensor | None
    attended: Tensor
    values: Trace

    def columns(self, part: slice) -> "ActionTrace":
        """Return the trace of these columns alone."""
        weights = None if self.weights is None else self.weights[..., part]
        state, option, attended = self.states[..., part], self.options[..., part], self.attended[..., part]
        return ActionTrace(state, option, weights, attended, self.values.columns(part))


class ActionNetwork:
    """Q^a of Figure 2: attention over the state elements given the option, then fully connected layers.

    w = softmax(Linear(s) + Linear(o)) and s^I = 11 w * s, so that uniform attention leaves the state as it is;
    `config.attended` = "linear" is the figure's literal s^I = 11 w * Linear(s). Without attention s^I = s. The layers
    read s^I beside the one-hot option. Without `config.sees_line` the last three elements of s, the stop-line's, are 0.
    """

    def __init__(self, parameters: Parameters, config: DoubleDQNConfig) -> None:
        self._values = MLP(subset(parameters, "values."), layer_norm=config.layer_norm)
        self._attention = subset(parameters, "attention.")
        self._of_linear = config.attended == "linear"
        self._sees_line = config.sees_line

    @staticmethod
    def shapes(features: int, hidden: tuple[int, ...], num_actions: int, *, attention: bool) -> Shapes:
        """Return the parameter shapes for `hidden` units a layer and `num_actions` outputs."""
        layers = mlp_shapes(features + NUM_OPTIONS, *hidden, num_actions)
        shapes = {f"values.{name}": shape for name, shape in layers.items()}
        if attention:
            shapes["attention.state.weight"] = (SIZE, SIZE)
            shapes["attention.state.bias"] = (1, SIZE)
            shapes["attention.option.weight"] = (NUM_OPTIONS, SIZE)
        return shapes

    def attention(self, states: Tensor, options: Tensor) -> Tensor:
        """Return the attention weights I(s, o), [E, 11, K], each column summing to 1; uniform without attention.

        states: [E, 11, K]; options: one-hot [E, 2, K].
        """
        if not self._attention:
            return torch.full_like(states[:, :SIZE], 1 / SIZE)
        return self._attend(self._seen(states), options)[0]

    def __call__(self, states: Tensor, options: Tensor) -> Tensor:
        """Return Q^a(s^I, o, .), [E, A, K], for states [E, 11, K] and one-hot options [E, 2, K]."""
        return self.trace(states, options)[0]

    def trace(self, states: Tensor, options: Tensor) -> tuple[Tensor, ActionTrace]:
        """Return the action values, and what `backward` needs."""
        states = self._seen(states)
        weights, attended = self._attend(states, options) if self._attention else (None, states)
        values, trace = self._values.trace(torch.cat((attended, options), 1))
        return values, ActionTrace(states, options, weights, attended, trace)

    def backward(self, trace: ActionTrace, values_grad: Tensor, gradients: Parameters) -> None:
        """Return nothing; write the parameters' gradients for the gradient by the values, [E, A, K]."""
        grad = self._values.backward(trace.values, values_grad, subset(gradients, "values."))
        if trace.weights is None:
            return
        attended_grad = torch.bmm(self._values.weights[0][:, : trace.states.shape[1]], grad)
        share = _grouped(attended_grad * trace.attended).sum(1)
        scores_grad = share.addcmul(trace.weights, share.sum(1, keepdim=True), value=-1.0)
        into = subset(gradients, "attention.")
        linear_backward(trace.options, scores_grad, into["option.weight"])
        if self._of_linear:
            scores_grad = scores_grad.addcmul_(attended_grad, trace.weights, value=SIZE)
        linear_backward(trace.states[:, :SIZE], scores_grad, into["state.weight"], into["state.bias"])

    def _seen(self, states: Tensor) -> Tensor:
        if self._sees_line:
            return states
        seen = _grouped(states.clone(memory_format=torch.contiguous_format))
        seen[:, :, D_D:] = 0.0
        return seen.flatten(1, 2)

    def _attend(self, states: Tensor, options: Tensor) -> tuple[Tensor, Tensor]:
        """Return I(s, o) and s^I, [E, 11, K] each."""
        by_name = self._attention
        scored = linear(by_name["state.weight"], by_name["state.bias"].transpose(1, 2), states[:, :SIZE])
        weights = linear(by_name["option.weight"], scored, options).softmax(1)
        if self._of_linear:
            return weights, (weights * scored).mul_(SIZE)
        return weights, (weights.unsqueeze(1) * _grouped(states)).mul_(SIZE).flatten(1, 2)


def _grouped(features: Tensor) -> Tensor:
    """Return [E, 1 + traces, 11, K] for features [E, 11 (1 + traces), K]."""
    return features.view(len(features), -1, SIZE, features.shape[2])


def subset(parameters: Parameters, prefix: str) -> dict[str, Tensor]:
    """Return the parameters whose names start with `prefix`, the prefix taken off."""
    return {name.removeprefix(prefix): value for name, value in parameters.items() if name.startswith(prefix)}


def method_shapes(method: Method, num_actions: int) -> Shapes:
    """Return the parameter shapes of the networks of the method's learned levels, their names behind `option.` etc."""
    hidden, features = method.config.hidden, method.config.features
    shapes = {
        "option": mlp_shapes(features, *hidden, NUM_OPTIONS),
        "action": mlp_shapes(features, *hidden, num_actions),
    }
    if method.hierarchical:
        shapes["action"] = ActionNetwork.shapes(features, hidden, num_actions, attention=method.attention)
    return {f"{level}.{name}": shape for level in method.levels for name, shape in shapes[level].items()}


def frozen_shapes(method: Method, num_actions: int) -> Shapes:
    """Return the parameter shapes of what the method does not learn: those of its FFV policy, behind `ffv.`."""
    shapes = method_shapes(method.ffv, num_actions) if method.ffv else {}
    return {f"{FFV}{name}": shape for name, shape in shapes.items()}


def one_hot(options: Tensor) -> Tensor:
    """Return float32 [E, 2, K] for integer options [E, 1, K]."""
    return (options == torch.arange(NUM_OPTIONS, device=options.device).unsqueeze(1)).float()


def mask_penalty(option_mask: tuple[bool, ...]) -> Tensor:
    """Return what to add to option values so that no absent option is the best, float32 [2, 1]: 0 or -infinity."""
    return torch.where(torch.tensor(option_mask), 0.0, -torch.inf).unsqueeze(1)
