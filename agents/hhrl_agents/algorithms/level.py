"""A learned level: the values of its choices for stacked seeds, and their temporal-difference errors."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor

from hhrl_agents.networks.mlp import Parameters
from hhrl_agents.networks.parameters import ParameterStack
from hhrl_agents.networks.value_networks import subset
from hhrl_agents.training.exploration import GREEDY
from hhrl_envs.arrays import Floats, Ints


class LevelErrors(NamedTuple):
    """The temporal-difference errors Y - Q of one level's network, and what their gradient needs.

    errors: [E, 1, M]; choices: whose values erred, int64 [E, 1, M]; values: of all choices, [E, C, M]; trace: of the
    network's forward pass; gradients: where its parameters' gradients belong.
    """

    errors: Tensor
    choices: Tensor
    values: Tensor
    network: Any
    trace: Any
    gradients: Parameters

    def backward(self, part: slice, weights: Tensor) -> Floats:
        """Return the losses float64 [E], the weighted mean squared errors of the columns `part`; write the gradients.

        weights: [E, 1, K] for the K columns of `part`.
        """
        errors = self.errors[..., part]
        weighted = errors * weights
        slope = torch.zeros_like(self.values[..., part])
        slope.scatter_(1, self.choices[..., part], weighted * (-2.0 / errors.shape[2]))
        self.network.backward(self.trace.columns(part), slope, self.gradients)
        losses: Floats = (weighted * errors).mean((1, 2)).cpu().double().numpy()
        return losses


class LearnedLevel:
    """One level of E stacked seeds: online and target networks of the parameters whose names begin with `level`.

    network: makes a network of its parameters; it is called with states [E, features, K], and with one-hot options
    where the level is given one. alpha: of advantage learning, 0 without. penalty: what its values are lowered by where
    a choice is absent, [C, 1].
    """

    def __init__(
        self,
        level: str,
        network: Callable[[Parameters], Any],
        stack: ParameterStack,
        alpha: float,
        penalty: Tensor | None = None,
    ) -> None:
        self._online = network(subset(stack.online, f"{level}."))
        self._target = network(subset(stack.target, f"{level}."))
        self._both = network(subset(stack.both, f"{level}."))
        self._gradients = subset(stack.gradients, f"{level}.")
        self._alpha, self._penalty = alpha, penalty

    def choose(self, tried: Ints, *inputs: Tensor) -> Ints:
        """Return the choices, int64 [E, n]: those `tried` [E, n], the best of the online network where it is GREEDY."""
        return np.where(tried == GREEDY, self._masked(self._online(*inputs)).max(1).indices.cpu().numpy(), tried)

    def following(self, *inputs: Tensor) -> tuple[Tensor, Tensor]:
        """Return the choices at the next states and their target values; see `double_q`.

        inputs: those of every seed's online network, then those of the target networks, [2E, features, K].
        """
        return double_q(self._masked(self._both(*inputs)))

    def errors(self, target: Tensor, choices: Tensor, *inputs: Tensor) -> LevelErrors:
        """Return the errors of the values of the `choices` made, int64 [E, 1, K], from the `target`, [E, 1, K]."""
        values, trace = self._online.trace(*inputs)
        errors = target - values.gather(1, choices)
        if self._alpha > 0.0:
            errors -= self._alpha * shortfall(self._masked(self._target(*inputs)), choices)
        return LevelErrors(errors, choices, values, self._online, trace, self._gradients)

    def _masked(self, values: Tensor) -> Tensor:
        return values if self._penalty is None else values + self._penalty


def double_q(values: Tensor) -> tuple[Tensor, Tensor]:
    """Return the online network's best choice, int64 [E, 1, K], and the target network's value of it, [E, 1, K].

    values: [2E, C, K], the online networks' of every seed, then the target networks'.
    """
    online, target = values.chunk(2)
    best = online.max(1, keepdim=True).indices
    return best, target.gather(1, best)


def shortfall(values: Tensor, choices: Tensor) -> Tensor:
    """Return how much less than the best of `values` [E, C, K] the value of each choice is, [E, 1, K]."""
    return values.max(1, keepdim=True).values - values.gather(1, choices)
