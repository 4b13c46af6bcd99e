"""The parameters of all networks for E seeds, online and target, with their gradients, and Adam, which moves them.

Each lies in one flat tensor, of which the parameters of all layers are views, so that clipping, the optimiser's step
and the copy to the target cost a few operations however many layers and seeds there are.
"""

from collections.abc import Sequence
from math import prod, sqrt

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import hardshrink

from hhrl_agents.networks.architectures import Parameters, Shapes
from hhrl_envs.arrays import Floats32
from hhrl_envs.state import State, count, read, read_count

_BETAS = (0.9, 0.999)
_EPSILON = 1e-8
TINY = 1e-30
"""Adam's averages below this are zero: they move nothing, and numbers that get denormal are some ten times slower."""
TINY_EVERY = 100
"""Adam's steps between two looks for such averages."""


class ParameterStack:
    """Online and target parameters for a stack of E seeds, P numbers each, on one device.

    flat, flat_target, gradient: all online parameters, all target parameters, and the gradient by the online ones,
    [E, P]; online, target, gradients: name -> views [E, in, out] of them.
    both: name -> tensor [2E, in, out]: the online parameters of every seed, then the target's.
    """

    def __init__(self, shapes: Shapes, streams: Sequence[np.random.Generator], device: torch.device) -> None:
        initial = np.stack([_initial(shapes, stream) for stream in streams])
        storage = torch.from_numpy(np.stack((initial, initial))).to(device)
        self._shapes = shapes
        self.flat, self.flat_target = storage
        self.gradient = torch.zeros_like(self.flat)
        self.online = _views(self.flat, shapes)
        self.target = _views(self.flat_target, shapes)
        self.both = _views(storage.flatten(0, 1), shapes)
        self.gradients = _views(self.gradient, shapes)

    def take_over(self, seed_index: int, parameters: Parameters) -> None:
        """Give one seed these parameters, name -> [1, in, out], online and target."""
        for name, value in parameters.items():
            for views in (self.online, self.target):
                views[name][seed_index].copy_(torch.from_numpy(value[0]))

    def part(self, prefix: str) -> slice:
        """Return where in `flat` the parameters lie whose names start with `prefix`."""
        sizes = [prod(shape) * name.startswith(prefix) for name, shape in self._shapes.items()]
        before = [prod(shape) for name, shape in self._shapes.items()]
        first = next(index for index, size in enumerate(sizes) if size)
        return slice(sum(before[:first]), sum(before[:first]) + sum(sizes))

    def move_target(self, rate: float) -> None:
        """Move the target's parameters by the share `rate` towards the online ones; 1 copies them."""
        self.flat_target.lerp_(self.flat, rate) if rate < 1.0 else self.flat_target.copy_(self.flat)

    def state(self) -> State:
        """Return all parameters, online and target; see `hhrl_agents.stateful.Stateful`."""
        return {name: flat.cpu().numpy().copy() for name, flat in (("online", self.flat), ("target", self.flat_target))}

    def restore(self, state: State) -> None:
        """Take up a state; see `hhrl_agents.stateful.Stateful`."""
        for name, flat in (("online", self.flat), ("target", self.flat_target)):
            flat.copy_(torch.from_numpy(read(state, name, flat.cpu().numpy())))

    def snapshot(self, seed_index: int) -> dict[str, Floats32]:
        """Return a copy of one seed's online parameters, name -> [1, in, out]."""
        views = _views(self.flat[seed_index : seed_index + 1].cpu(), self._shapes)
        return {name: view.numpy().copy() for name, view in views.items()}


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
        """Take up a state; see `hhrl_agents.stateful.Stateful`."""
        for name, average in self._averages.items():
            average.copy_(torch.from_numpy(read(state, name, average.cpu().numpy())))
        self.steps = read_count(state, "steps")

    def step(self, gradient: Tensor, learning_rate: float) -> None:
        """Move the parameters down the gradient [E, P], which is clipped in place.

        In every part the gradient's norm is at most `max_norm`, for each seed by itself.
        """
        for part in self._parts:
            norms = torch.linalg.vector_norm(gradient[:, part], dim=1, keepdim=True)
            gradient[:, part].mul_((self._max_norm / (norms + 1e-6)).clamp_(max=1.0))
        if self.steps % TINY_EVERY == 0:
            for average in (self.mean, self.variance):
                average.copy_(hardshrink(average, TINY))
        self.steps += 1
        self.mean.lerp_(gradient, 1 - _BETAS[0])
        self.variance.mul_(_BETAS[1]).addcmul_(gradient, gradient, value=1 - _BETAS[1])
        spread = torch.sqrt(self.variance, out=self._spread)
        spread.mul_((1 - _BETAS[1] ** self.steps) ** -0.5).add_(_EPSILON)
        self._parameters.addcdiv_(self.mean, spread, value=-learning_rate / (1 - _BETAS[0] ** self.steps))


def _views(flat: Tensor, shapes: Shapes) -> dict[str, Tensor]:
    sections = torch.split(flat, [prod(shape) for shape in shapes.values()], dim=1)
    return {name: part.view(-1, *shape) for (name, shape), part in zip(shapes.items(), sections, strict=True)}


def _initial(shapes: Shapes, stream: np.random.Generator) -> Floats32:
    """Return one seed's parameters in the order of `shapes`: weights uniform in +-1/sqrt(fan in), biases zero."""
    bounds = [1.0 / sqrt(shape[0]) if name.endswith(".weight") else 0.0 for name, shape in shapes.items()]
    parts = [stream.uniform(-bound, bound, prod(shape)) for bound, shape in zip(bounds, shapes.values(), strict=True)]
    return np.concatenate(parts).astype(np.float32)
