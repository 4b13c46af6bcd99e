"""The value networks of Figure 2 for stacked seeds: option values from states, action values from states and options.

Networks are plain functions of a mapping from parameter names to tensors, so that the same code evaluates online and
target parameters, one seed or many. States are columns, [E, features, K], and so are values; see
`hhrl_agents.networks.mlp`. The values of a flat method and of the option level are those of an `MLP`.
"""

from typing import NamedTuple

import torch
from torch import Tensor

from hhrl_agents.methods.configs import DoubleDQNConfig
from hhrl_agents.networks.attention import Attended, Attention, by_element
from hhrl_agents.networks.mlp import MLP, ForwardPass, Parameters, subset
from hhrl_envs.observation import SYMBOLS
from hhrl_envs.sub_goals import SSL

_LINE = [SYMBOLS.index(element.symbol) for element in SSL.elements]


class ActionForwardPass(NamedTuple):
    """What a forward pass leaves for `ActionNetwork.backward`."""

    attended: Attended | None
    values: ForwardPass

    def columns(self, part: slice) -> "ActionForwardPass":
        """Return what it leaves of these columns alone."""
        attended = None if self.attended is None else self.attended.columns(part)
        return ActionForwardPass(attended, self.values.columns(part))


class ActionNetwork:
    """Q^a of Figure 2: attention over the state elements given the option, then fully connected layers.

    The layers read s^I beside the one-hot option; without attention s^I = s. `config.attended` = "linear" is the
    figure's literal attention. Without `config.sees_line` the elements of s that belong to the stop-line are 0.
    """

    def __init__(self, parameters: Parameters, config: DoubleDQNConfig) -> None:
        self._values = MLP(subset(parameters, "values."), layer_norm=config.layer_norm)
        attention = subset(parameters, "attention.")
        self._attention = Attention(attention, of_linear=config.attended == "linear") if attention else None
        self._sees_line = config.sees_line

    def __call__(self, states: Tensor, options: Tensor) -> Tensor:
        """Return Q^a(s^I, o, .), [E, A, K], for states [E, features, K] and one-hot options [E, options, K]."""
        return self.forward(states, options)[0]

    def forward(self, states: Tensor, options: Tensor) -> tuple[Tensor, ActionForwardPass]:
        """Return the action values, and what `backward` needs."""
        states = self._seen(states)
        attended = None if self._attention is None else self._attention(states, options)
        inputs = states if attended is None else attended.attended
        values, kept = self._values.forward(torch.cat((inputs, options), 1))
        return values, ActionForwardPass(attended, kept)

    def backward(self, kept: ActionForwardPass, values_grad: Tensor, gradients: Parameters) -> None:
        """Write the parameters' gradients for the gradient by the values, [E, A, K]."""
        grad = self._values.backward(kept.values, values_grad, subset(gradients, "values."))
        if self._attention is not None and kept.attended is not None:
            features = kept.attended.states.shape[1]
            attended_grad = torch.bmm(self._values.weights[0][:, :features], grad)
            self._attention.backward(kept.attended, attended_grad, subset(gradients, "attention."))

    def _seen(self, states: Tensor) -> Tensor:
        if self._sees_line:
            return states
        seen = by_element(states.clone(memory_format=torch.contiguous_format))
        seen[:, :, _LINE] = 0.0
        return seen.flatten(1, 2)


def mask_penalty(option_mask: tuple[bool, ...]) -> Tensor:
    """Return what to add to option values so that no absent option is best, float32 [options, 1]: 0 or -infinity."""
    return torch.where(torch.tensor(option_mask), 0.0, -torch.inf).unsqueeze(1)
