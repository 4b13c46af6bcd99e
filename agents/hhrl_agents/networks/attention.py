"""The attention of Figure 2: which elements of the state the action level attends to, given the option."""

from typing import NamedTuple

import torch
from torch import Tensor

from hhrl_agents.networks.architectures import NUM_OPTIONS
from hhrl_agents.networks.mlp import Parameters, affine, affine_backward
from hhrl_envs.observation import SIZE


class Attended(NamedTuple):
    """What attending leaves for `Attention.backward`.

    states: what was attended to, [E, features, K]; options: one-hot, [E, options, K]; weights: I(s, o), [E, SIZE, K];
    attended: s^I, [E, features, K].
    """

    states: Tensor
    options: Tensor
    weights: Tensor
    attended: Tensor

    def columns(self, part: slice) -> "Attended":
        """Return what it leaves of these columns alone."""
        return Attended(*(tensor[..., part] for tensor in self))


class Attention:
    """I(s, o) = softmax(Linear(s) + Linear(o)) and s^I = SIZE I * s, so that uniform attention leaves s as it is.

    of_linear: the figure's literal s^I = SIZE I * Linear(s). The weights come from the state alone, and weigh its
    traces too, which lie behind it.
    """

    def __init__(self, parameters: Parameters, *, of_linear: bool = False) -> None:
        self._state_weight, self._option_weight = parameters["state.weight"], parameters["option.weight"]
        self._state_bias = parameters["state.bias"].transpose(1, 2)
        self._of_linear = of_linear

    def __call__(self, states: Tensor, options: Tensor) -> Attended:
        """Return the weights and what is attended, for states [E, features, K] and one-hot options [E, options, K]."""
        scored = affine(self._state_weight, self._state_bias, states[:, :SIZE])
        weights = affine(self._option_weight, scored, options).softmax(1)
        if self._of_linear:
            attended = (weights * scored).mul_(SIZE)
        else:
            attended = (weights.unsqueeze(1) * by_element(states)).mul_(SIZE).flatten(1, 2)
        return Attended(states, options, weights, attended)

    def backward(self, kept: Attended, attended_grad: Tensor, gradients: Parameters) -> None:
        """Write the parameters' gradients for the gradient by s^I, [E, features, K]."""
        share = by_element(attended_grad * kept.attended).sum(1)
        scores_grad = share.addcmul(kept.weights, share.sum(1, keepdim=True), value=-1.0)
        affine_backward(kept.options, scores_grad, gradients["option.weight"])
        if self._of_linear:
            scores_grad = scores_grad.addcmul_(attended_grad, kept.weights, value=SIZE)
        affine_backward(kept.states[:, :SIZE], scores_grad, gradients["state.weight"], gradients["state.bias"])


def by_element(features: Tensor) -> Tensor:
    """Return [E, 1 + traces, SIZE, K] for features [E, SIZE (1 + traces), K]."""
    return features.view(len(features), -1, SIZE, features.shape[2])


def one_hot(options: Tensor) -> Tensor:
    """Return float32 [E, options, K] for integer options [E, 1, K]."""
    return (options == torch.arange(NUM_OPTIONS, device=options.device).unsqueeze(1)).float()
