"""The parameters of one network for E seeds, online and target, in one flat tensor.

The parameters of all layers are views of it, so that clipping, Adam's step and the copy to the target cost a few
operations however many layers and seeds there are.
"""

from collections.abc import Sequence
from math import prod, sqrt

import numpy as np
import torch
from torch import Tensor

from hhrl_agents.base import Float32Array
from hhrl_agents.networks import Shapes


class ParameterStack:
    """Online and target parameters of one network for a stack of E seeds, P numbers each.

    online: name -> leaf tensor [E, in, out].
    both: name -> tensor [2E, in, out] without gradient: the online parameters of every seed, then the target's.
    flat: all online parameters [E, P], for the optimiser.
    """

    def __init__(self, shapes: Shapes, streams: Sequence[np.random.Generator]) -> None:
        initial = np.stack([_initial(shapes, stream) for stream in streams])
        self._storage = torch.from_numpy(np.stack((initial, initial)))
        self._shapes = shapes
        self.flat = torch.nn.Parameter(self._storage[0])
        self.both = _views(self._storage.flatten(0, 1), shapes)
        self.online = {name: view.requires_grad_() for name, view in _views(self._storage[0], shapes).items()}

    def set_gradients(self, losses: Tensor, max_norm: float) -> None:
        """Return nothing; give `flat` the gradient of the summed losses [E], each seed's norm at most `max_norm`."""
        parts = torch.autograd.grad(losses.sum(), list(self.online.values()))
        gradient = torch.cat([part.flatten(1) for part in parts], dim=1)
        norms = torch.linalg.vector_norm(gradient, dim=1, keepdim=True)
        self.flat.grad = gradient.mul_((max_norm / (norms + 1e-6)).clamp_(max=1.0))

    def copy_to_target(self) -> None:
        """Return nothing; set the target's parameters to the online ones."""
        self._storage[1] = self._storage[0]

    def snapshot(self, seed_index: int) -> dict[str, Tensor]:
        """Return a copy of one seed's online parameters, name -> [1, in, out]."""
        views = _views(self._storage[0, seed_index : seed_index + 1], self._shapes)
        return {name: view.clone(memory_format=torch.contiguous_format) for name, view in views.items()}


def _views(flat: Tensor, shapes: Shapes) -> dict[str, Tensor]:
    sections = torch.split(flat, [prod(shape) for shape in shapes.values()], dim=1)
    return {name: part.view(-1, *shape) for (name, shape), part in zip(shapes.items(), sections, strict=True)}


def _initial(shapes: Shapes, stream: np.random.Generator) -> Float32Array:
    """Return one seed's parameters in the order of `shapes`: weights uniform in +-1/sqrt(fan in), biases zero."""
    bounds = [1.0 / sqrt(shape[0]) if name.endswith(".weight") else 0.0 for name, shape in shapes.items()]
    parts = [stream.uniform(-bound, bound, prod(shape)) for bound, shape in zip(bounds, shapes.values(), strict=True)]
    return np.concatenate(parts).astype(np.float32)
