"""The parameters of all networks of a seed, online and target, and Adam, which moves them, in compiled code."""

from math import prod, sqrt
from typing import NamedTuple

import numpy as np

from hhrl_agents.networks.architectures import Architecture, Parameters, Shapes
from hhrl_agents.networks.arithmetic import ONE, ZERO, fma, matrix, stack
from hhrl_agents.networks.layers import layout_of
from hhrl_envs.arrays import Floats, Floats32, Ints
from hhrl_envs.simulation.engine.compilation import inner, spliced
from hhrl_envs.state import State, read

_BETA_1, _BETA_2 = np.float32(0.9), np.float32(0.999)
_REST_1, _REST_2 = np.float32(0.1), np.float32(0.001)
_EPSILON = np.float32(1e-8)
_LANES = 16
TINY = np.float32(1e-30)
"""Adam's averages below this are zero: they move nothing, and numbers that get denormal are some ten times slower."""


class ParameterSet:
    """Online and target parameters of the networks of all levels, P numbers each, in the order of `shapes`.

    online, target: float32 [P]; layouts: level -> where its network's lie in them, see `hhrl_agents.networks.layers`;
    widths: level -> numbers of a row of its workspace; parts: level -> (first, last + 1) of its parameters.
    """

    def __init__(self, networks: dict[str, Architecture], stream: np.random.Generator) -> None:
        self.shapes: Shapes = {
            f"{level}.{name}": shape for level, network in networks.items() for name, shape in network.shapes().items()
        }
        self.online = _initial(self.shapes, stream)
        self.target = self.online.copy()
        self.layouts: dict[str, Ints] = {}
        self.widths: dict[str, int] = {}
        self.parts: dict[str, tuple[int, int]] = {}
        first = 0
        for level, network in networks.items():
            self.layouts[level], self.widths[level] = layout_of(network, first)
            last = first + sum(map(prod, network.shapes().values()))
            self.parts[level], first = (first, last), last

    def take_over(self, parameters: Parameters) -> None:
        """Take over these parameters, name -> [1, in, out], online and target."""
        for flat in (self.online, self.target):
            views = self._views(flat)
            for name, value in parameters.items():
                views[name][...] = value

    def move_target(self, rate: float) -> None:
        """Move the target's parameters by the share `rate` towards the online ones; 1 copies them."""
        if rate == 1.0:
            self.target[:] = self.online
        else:
            self.target += np.float32(rate) * (self.online - self.target)

    def snapshot(self) -> dict[str, Floats32]:
        """Return a copy of the online parameters, name -> [1, in, out]."""
        return {name: view.copy() for name, view in self._views(self.online).items()}

    def state(self) -> State:
        """Return all parameters, online and target; see `hhrl_agents.stateful.Stateful`."""
        return {"online": self.online.copy(), "target": self.target.copy()}

    def restore(self, state: State) -> None:
        """Take up a state; see `hhrl_agents.stateful.Stateful`."""
        self.online[:] = read(state, "online", self.online)
        self.target[:] = read(state, "target", self.target)

    def _views(self, flat: Floats32) -> dict[str, Floats32]:
        sections = np.split(flat, np.cumsum([prod(shape) for shape in self.shapes.values()])[:-1])
        return {
            name: part.reshape(1, *shape) for (name, shape), part in zip(self.shapes.items(), sections, strict=True)
        }


def _initial(shapes: Shapes, stream: np.random.Generator) -> Floats32:
    """Return parameters in the order of `shapes`: weights uniform in +-1/sqrt(fan in), biases zero."""
    bounds = [1.0 / sqrt(shape[0]) if name.endswith(".weight") else 0.0 for name, shape in shapes.items()]
    parts = [stream.uniform(-bound, bound, prod(shape)) for bound, shape in zip(bounds, shapes.values(), strict=True)]
    return np.concatenate(parts).astype(np.float32)


class Adam:
    """What Adam (Kingma and Ba, 2015) knows of P parameters.

    gradient, mean, variance: float32 [P]; powers: of both betas by the steps so far, float64 [2].
    """

    def __init__(self, size: int) -> None:
        self.gradient, self.mean, self.variance = (np.zeros(size, np.float32) for _ in range(3))
        self.powers: Floats = np.ones(2)

    def state(self) -> State:
        """Return both averages and the powers; see `hhrl_agents.stateful.Stateful`."""
        return {name: array.copy() for name, array in self._memory().items()}

    def restore(self, state: State) -> None:
        """Take up a state; see `hhrl_agents.stateful.Stateful`."""
        for name, array in self._memory().items():
            array[:] = read(state, name, array)

    def _memory(self) -> State:
        return {"mean": self.mean, "variance": self.variance, "powers": self.powers}


class Memory(NamedTuple):
    """All numbers that learning changes beside the replay: parameters and Adam's averages [P], powers float64 [2]."""

    online: Floats32
    target: Floats32
    gradient: Floats32
    mean: Floats32
    variance: Floats32
    powers: Floats


@inner
def advance_powers(powers: Floats) -> None:
    """Count a step of Adam."""
    powers[0] *= 0.9
    powers[1] *= 0.999


@spliced
def descend(memory: Memory, first: int, last: int, learning_rate: float, max_norm: float) -> None:
    """Move the parameters from `first` to `last` by a step of Adam; the norm of their gradient counts to `max_norm`."""
    size, gradient = last - first, matrix(memory.gradient, first, 1, last - first)
    norm = np.sqrt(_squares(gradient))
    scale = np.float32(max_norm / (norm + 1e-6)) if norm > max_norm else ONE
    step = np.float32(learning_rate / (1.0 - memory.powers[0]))
    spread = np.float32(1.0 / np.sqrt(1.0 - memory.powers[1]))
    online, mean = matrix(memory.online, first, 1, size), matrix(memory.mean, first, 1, size)
    _move(online, gradient, mean, matrix(memory.variance, first, 1, size), scale, step, spread)


@inner
def _move(
    online: Floats32,
    gradient: Floats32,
    mean: Floats32,
    variance: Floats32,
    scale: np.float32,
    step: np.float32,
    spread: np.float32,
) -> None:
    """Take a step of Adam with numbers [1, P]; all averages are divided by what the first steps lack."""
    for p in range(online.shape[1]):
        slope = gradient[0, p] * scale
        m = fma(_BETA_1, mean[0, p], _REST_1 * slope)
        v = fma(_BETA_2, variance[0, p], _REST_2 * slope * slope)
        m = ZERO if abs(m) < TINY else m
        v = ZERO if v < TINY else v
        mean[0, p], variance[0, p] = m, v
        online[0, p] -= step * m / fma(np.sqrt(v), spread, _EPSILON)


@inner
def _squares(gradient: Floats32) -> float:
    """Return the sum of squares [1, P], in sixteen lanes that are added in their order."""
    lanes = stack(_LANES)
    for lane in range(_LANES):
        lanes[0, lane] = 0.0
    whole = gradient.size - gradient.size % _LANES
    for p in range(0, whole, _LANES):
        for lane in range(_LANES):
            slope = np.float64(gradient[0, p + lane])
            lanes[0, lane] = fma(slope, slope, lanes[0, lane])
    for p in range(whole, gradient.size):
        slope = np.float64(gradient[0, p])
        lanes[0, p - whole] = fma(slope, slope, lanes[0, p - whole])
    total = 0.0
    for lane in range(_LANES):
        total += lanes[0, lane]
    return total
