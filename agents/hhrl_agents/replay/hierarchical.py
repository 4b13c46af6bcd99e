"""Prioritised experience replay: plain, and hierarchical with priorities for each level (Algorithm 3)."""

import numpy as np

from hhrl_agents.agent import ACTION, OPTION
from hhrl_agents.methods.configs import DoubleDQNConfig
from hhrl_agents.methods.method import Method
from hhrl_agents.networks.arithmetic import matrix, raise_all
from hhrl_agents.replay.buffer import Draw, Sampler, UniformSampler
from hhrl_agents.replay.sum_tree import FAN_OUT, SumTrees, assign, find, place
from hhrl_agents.seeding import restore_stream, save_stream
from hhrl_envs.arrays import Floats, Floats32, Ints
from hhrl_envs.simulation.engine.compilation import kernel, spliced
from hhrl_envs.state import State, read

SCALE_RATE = 0.01
"""Rate at which the running magnitude of a level's TD error follows the batches."""

_MEAN, _CLIP, _SHIFT = range(3)
_SMALLEST = 1e-12  # magnitude that errors are divided by


class PrioritisedSampler:
    """Prioritised replay: plain (Schaul et al., 2016), or hierarchical (Algorithm 3) with a tree for each level.

    P ~ p^alpha, and a level's loss weighs its mini-batch by [N P]^-beta / max, N the number of stored transitions. The
    TD errors of all levels are evaluated on every drawn transition, so each gets all its priorities; new transitions
    get the highest so far. With every error divided by its level's running magnitude, the plain priority, of the one
    mini-batch that all levels learn from, is the mean error of the levels. The hierarchical ones, Eq. (pri), each with
    a mini-batch of its own, are p^o = |delta_o| and p^a = max(|delta_a| - |delta_o|, 0). `config.priority` = "shift" is
    the paper's literal p^a, the undivided |delta_a| - |delta_o| minus its minimum over the mini-batches.
    """

    def __init__(
        self,
        stream: np.random.Generator,
        levels: int,
        capacity: int,
        config: DoubleDQNConfig,
        *,
        hierarchical: bool = False,
    ) -> None:
        self._stream, self._config = stream, config
        trees = levels if hierarchical else 1
        self._kind = (_SHIFT if config.priority == "shift" else _CLIP) if hierarchical else _MEAN
        self._firsts = np.arange(levels) % trees * config.batch_size
        self._trees = SumTrees(trees, capacity)
        self._highest: Floats = np.ones(trees)
        self._magnitude: Floats = np.zeros(levels)
        self._of_option: Floats = np.zeros(capacity)  # p^o as the option level last found it

    def added(self, indices: Ints) -> None:
        """Give the new transitions the highest priority; see `Sampler.added`."""
        highest = np.repeat(self._highest[:, None], indices.size, axis=1)
        self._of_option[indices[indices >= 0]] = 0.0
        place(self._trees.nodes, self._trees.starts, indices, highest)

    def draw(self, stored: int) -> Draw:
        """Return each tree's mini-batch, one beside the other; see `Sampler.draw`."""
        config, trees = self._config, self._trees
        shares = self._stream.random((len(trees.nodes), config.batch_size))
        indices, weights = np.empty(shares.shape, np.int64), np.empty(shares.shape, np.float32)
        _draw(trees.nodes, trees.starts, shares, stored, config.importance_exponent, indices, weights)
        return Draw(indices.ravel(), self._firsts, weights[self._firsts // config.batch_size])

    def update(self, indices: Ints, errors: Floats32) -> None:
        """Give the drawn transitions their new priorities in every tree; see `Sampler.update`."""
        config, trees = self._config, self._trees
        if self._kind == _CLIP:
            own = (self._highest, self._magnitude, self._of_option, config.priority_floor, config.priority_exponent)
            _update_own(trees.nodes, trees.starts, indices, errors, *own, np.empty((1, config.batch_size)))
            return
        scaled, priorities = np.empty(errors.shape), np.empty((len(trees.nodes), indices.size))
        given = (self._kind, config.priority_floor, config.priority_exponent, scaled, priorities)
        _update(trees.nodes, trees.starts, indices, errors, self._highest, self._magnitude, *given)

    def state(self) -> State:
        """Return generator, trees, highest priorities and magnitudes; see `hhrl_agents.stateful.Stateful`."""
        return {**save_stream(self._stream), **{name: array.copy() for name, array in self._memory().items()}}

    def restore(self, state: State) -> None:
        """Take up a state; see `hhrl_agents.stateful.Stateful`."""
        restore_stream(self._stream, state)
        for name, array in self._memory().items():
            array[...] = read(state, name, array)

    def _memory(self) -> State:
        return {"trees": self._trees.nodes, "highest": self._highest, "magnitude": self._magnitude, "of_option": self._of_option}


@kernel
def _draw(
    nodes: Floats, starts: Ints, shares: Floats, stored: int, beta: float, found: Ints, weights: Floats32
) -> None:
    """Write what is drawn from every tree, int64 [T, K], and the weights, float32 [T, K].

    shares: a uniform for each stratum, float64 [T, K]; what they become has no meaning.
    """
    trees, size = shares.shape
    for t in range(trees):
        for k in range(size):
            shares[t, k] = (k + shares[t, k]) / size
    find(nodes, starts, shares, found)
    for t in range(trees):
        total, largest = 0.0, 0.0
        for child in range(FAN_OUT):
            total += nodes[t, child]
        for k in range(size):
            shares[t, k] = stored * (nodes[t, starts[-1] + found[t, k]] / total)
        raise_all(matrix(shares, t * size, 1, size), beta)
        for k in range(size):
            shares[t, k] = 1.0 / shares[t, k]
            largest = max(largest, shares[t, k])
        for k in range(size):
            weights[t, k] = np.float32(shares[t, k] / largest)


@kernel
def _update(
    nodes: Floats,
    starts: Ints,
    indices: Ints,
    errors: Floats32,
    highest: Floats,
    magnitude: Floats,
    kind: int,
    floor: float,
    exponent: float,
    scaled: Floats,
    priorities: Floats,
) -> None:
    """Give the transitions `indices` [M] their priorities in every tree by their errors [levels, M].

    scaled: room for absolute errors, float64 [levels, M]; priorities: for what they give, float64 [T, M].
    """
    for level in range(errors.shape[0]):
        for m in range(indices.size):
            scaled[level, m] = abs(np.float64(errors[level, m]))
    if kind != _SHIFT:
        _scale(scaled, magnitude)
    _rank(scaled, kind, priorities)
    for t in range(nodes.shape[0]):
        for m in range(indices.size):
            priorities[t, m] += floor
    raise_all(priorities, exponent)
    for t in range(nodes.shape[0]):
        for m in range(indices.size):
            highest[t] = max(highest[t], priorities[t, m])
    assign(nodes, starts, indices, priorities)


@kernel
def _update_own(
    nodes: Floats,
    starts: Ints,
    indices: Ints,
    errors: Floats32,
    highest: Floats,
    magnitude: Floats,
    of_option: Floats,
    floor: float,
    exponent: float,
    priorities: Floats,
) -> None:
    """Give each level's mini-batch its new priorities in that level's tree; p^a by the p^o that is stored."""
    size = priorities.shape[1]
    for level in range(nodes.shape[0]):
        begin = level * size
        mean = 0.0
        for k in range(size):
            priorities[0, k] = abs(np.float64(errors[level, begin + k]))
            mean += priorities[0, k]
        mean /= size
        rate = 1.0 if magnitude[level] == 0.0 else SCALE_RATE
        magnitude[level] += rate * (mean - magnitude[level])
        for k in range(size):
            scaled = priorities[0, k] / max(magnitude[level], _SMALLEST)
            if level == OPTION:
                of_option[indices[begin + k]] = scaled
            else:
                scaled = max(scaled - of_option[indices[begin + k]], 0.0)
            priorities[0, k] = scaled + floor
        raise_all(priorities, exponent)
        for k in range(size):
            highest[level] = max(highest[level], priorities[0, k])
        assign(nodes[level : level + 1], starts, indices[begin : begin + size], priorities)


@spliced
def _scale(errors: Floats, magnitude: Floats) -> None:
    """Divide absolute errors [levels, M] by their level's running magnitude, these errors in it."""
    for level in range(errors.shape[0]):
        mean = 0.0
        for m in range(errors.shape[1]):
            mean += errors[level, m]
        mean /= errors.shape[1]
        rate = 1.0 if magnitude[level] == 0.0 else SCALE_RATE
        magnitude[level] += rate * (mean - magnitude[level])
        for m in range(errors.shape[1]):
            errors[level, m] /= max(magnitude[level], _SMALLEST)


@spliced
def _rank(errors: Floats, kind: int, priorities: Floats) -> None:
    """Write the priorities [trees, M] of absolute errors [levels, M], before floor and exponent."""
    levels = errors.shape[0]
    lowest = 0.0
    if kind == _SHIFT:
        lowest = errors[ACTION, 0] - errors[OPTION, 0]
        for m in range(errors.shape[1]):
            lowest = min(lowest, errors[ACTION, m] - errors[OPTION, m])
    for m in range(errors.shape[1]):
        if kind == _MEAN:
            total = 0.0
            for level in range(levels):
                total += errors[level, m]
            priorities[0, m] = total / levels
        else:
            priorities[OPTION, m] = errors[OPTION, m]
            priorities[ACTION, m] = max(errors[ACTION, m] - errors[OPTION, m] - lowest, 0.0)


def make_sampler(method: Method, stream: np.random.Generator, levels: int, capacity: int) -> Sampler:
    """Return the sampler that the method asks for, for a buffer of `capacity` transitions and `levels` networks."""
    if method.replay == "uniform":
        return UniformSampler(stream, levels, method.config.batch_size)
    hierarchical = method.replay == "hierarchical" and levels > 1  # of one level the hierarchy is the plain one
    return PrioritisedSampler(stream, levels, capacity, method.config, hierarchical=hierarchical)
