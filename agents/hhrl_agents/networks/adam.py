"""Adam for stacked seeds: one step of all parameters of all seeds, each network's gradient clipped seed by seed."""

from collections.abc import Sequence

import torch
from torch import Tensor
from torch.nn.functional import hardshrink

from hhrl_envs.state import State, count, read, read_count

BETAS = (0.9, 0.999)
EPSILON = 1e-8
TINY = 1e-30
"""Averages below this are zero: they move nothing, and numbers that get denormal are some ten times slower."""
TINY_EVERY = 100


class Adam:
    """Adam (Kingma and Ba, 2015) on a flat tensor of parameters, [E, P]; `parts` of it are clipped by themselves."""

    def __init__(self, parameters: Tensor, parts: Sequence[slice], max_norm: float) -> None:
        self._parameters = parameters
        self._parts, self._max_norm = parts, max_norm
        self.mean = torch.zeros_like(parameters)
        self.variance = torch.zeros_like(parameters)
        self._averages = {"mean": self.mean, "variance": self.variance}
        self._spread = torch.empty_like(parameters)
        self.steps = 0

    def state(self) -> State:
        """Return both averages and the number of steps; see `hhrl_agents.stateful.Stateful`."""
        averages = {name: average.cpu().numpy().copy() for name, average in self._averages.items()}
        return {**averages, "steps": count(self.steps)}

    def restore(self, state: State) -> None:
        """Return nothing; see `hhrl_agents.stateful.Stateful`."""
        for name, average in self._averages.items():
            average.copy_(torch.from_numpy(read(state, name, average.cpu().numpy())))
        self.steps = read_count(state, "steps")

    def step(self, gradient: Tensor, learning_rate: float) -> None:
        """Return nothing; move the parameters down the gradient [E, P], which is clipped in place.

        In every part the gradient's norm is at most `max_norm`, for each seed by itself.
        """
        for part in self._parts:
            norms = torch.linalg.vector_norm(gradient[:, part], dim=1, keepdim=True)
            gradient[:, part].mul_((self._max_norm / (norms + 1e-6)).clamp_(max=1.0))
        if self.steps % TINY_EVERY == 0:
            for average in (self.mean, self.variance):
                average.copy_(hardshrink(average, TINY))
        self.steps += 1
        self.mean.lerp_(gradient, 1 - BETAS[0])
        self.variance.mul_(BETAS[1]).addcmul_(gradient, gradient, value=1 - BETAS[1])
        spread = torch.sqrt(self.variance, out=self._spread)
        spread.mul_((1 - BETAS[1] ** self.steps) ** -0.5).add_(EPSILON)
        self._parameters.addcdiv_(self.mean, spread, value=-learning_rate / (1 - BETAS[0] ** self.steps))
