"""The parameters of all networks for E seeds, online and target, with their gradients, each in one flat tensor.

The parameters of all layers are views of it, so that clipping, the optimiser's step and the copy to the target cost a
few operations however many layers and seeds there are.
"""

from collections.abc import Mapping, Sequence
from math import prod, sqrt

import numpy as np
import torch
from torch import Tensor

from hhrl_agents.networks.mlp import Shapes
from hhrl_envs.arrays import Floats32
from hhrl_envs.state import State, read


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

    def take_over(self, seed_index: int, parameters: Mapping[str, Tensor]) -> None:
        """Return nothing; give one seed these parameters, name -> [1, in, out], online and target."""
        for name, value in parameters.items():
            for views in (self.online, self.target):
                views[name][seed_index].copy_(value[0])

    def part(self, prefix: str) -> slice:
        """Return where in `flat` the parameters lie whose names start with `prefix`."""
        sizes = [prod(shape) * name.startswith(prefix) for name, shape in self._shapes.items()]
        before = [prod(shape) for name, shape in self._shapes.items()]
        first = next(index for index, size in enumerate(sizes) if size)
        return slice(sum(before[:first]), sum(before[:first]) + sum(sizes))

    def move_target(self, rate: float) -> None:
        """Return nothing; move the target's parameters by the share `rate` towards the online ones; 1 copies them."""
        self.flat_target.lerp_(self.flat, rate) if rate < 1.0 else self.flat_target.copy_(self.flat)

    def state(self) -> State:
        """Return all parameters, online and target; see `hhrl_agents.stateful.Stateful`."""
        return {name: flat.cpu().numpy().copy() for name, flat in (("online", self.flat), ("target", self.flat_target))}

    def restore(self, state: State) -> None:
        """Return nothing; see `hhrl_agents.stateful.Stateful`."""
        for name, flat in (("online", self.flat), ("target", self.flat_target)):
            flat.copy_(torch.from_numpy(read(state, name, flat.cpu().numpy())))

    def snapshot(self, seed_index: int) -> dict[str, Tensor]:
        """Return a copy of one seed's online parameters on the CPU, name -> [1, in, out]."""
        views = _views(self.flat[seed_index : seed_index + 1].cpu(), self._shapes)
        return {name: view.clone(memory_format=torch.contiguous_format) for name, view in views.items()}


def _views(flat: Tensor, shapes: Shapes) -> dict[str, Tensor]:
    sections = torch.split(flat, [prod(shape) for shape in shapes.values()], dim=1)
    return {name: part.view(-1, *shape) for (name, shape), part in zip(shapes.items(), sections, strict=True)}


def _initial(shapes: Shapes, stream: np.random.Generator) -> Floats32:
    """Return one seed's parameters in the order of `shapes`: weights uniform in +-1/sqrt(fan in), biases zero."""
    bounds = [1.0 / sqrt(shape[0]) if name.endswith(".weight") else 0.0 for name, shape in shapes.items()]
    parts = [stream.uniform(-bound, bound, prod(shape)) for bound, shape in zip(bounds, shapes.values(), strict=True)]
    return np.concatenate(parts).astype(np.float32)
