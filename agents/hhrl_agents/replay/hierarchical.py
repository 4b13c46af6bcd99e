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

_SMALLEST = 1e-12  # magnitude that errors are divided by


class PrioritisedSampler:
    """Prioritised replay: plain (Schaul et al., 2016), or hierarchical (Algorithm 3) with a tree for each level.

    P ~ p^alpha, and a level's loss weighs its mini-batch by [N P]^-beta / max, N the number of stored transitions. New
    transitions get the highest priority so far. Every error is divided by its level's running magnitude. The plain
    priority, of the one mini-batch that all levels learn from, is the mean error of the levels. The hierarchical ones,
    Eq. (pri), are p^o = |delta_o| and p^a = max(|delta_a| - p^o, 0). Each level has a mini-batch and so finds errors of
    its own; the p^o in p^a is the one that the option level found when it last learned from that transition, and 0
    before. `config.priority` = "shift" is the paper's literal p^a, the undivided |delta_a| - p^o minus its minimum over
    the mini-batch.
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
        self._hierarchical = hierarchical
        self._tree_of = np.arange(levels) % trees
        self._firsts = self._tree_of * config.batch_size
        self._trees = SumTrees(trees, capacity)
        self._highest: Floats = np.ones(trees)
        self._magnitude: Floats = np.zeros(levels)
        self._of_option: Floats = np.zeros(capacity if hierarchical else 0)

    def added(self, indices: Ints) -> None:
        """Give the new transitions the highest priority; see `Sampler.added`."""
        highest = np.repeat(self._highest[:, None], indices.size, axis=1)
        if self._hierarchical:
            self._of_option[indices[indices >= 0]] = 0.0
        place(self._trees.nodes, self._trees.starts, indices, highest)

    def draw(self, stored: int) -> Draw:
        """Return each tree's mini-batch, one beside the other; see `Sampler.draw`."""
        config, trees = self._config, self._trees
        shares = self._stream.random((len(trees.nodes), config.batch_size))
        indices, weights = np.empty(shares.shape, np.int64), np.empty(shares.shape, np.float32)
        _draw(trees.nodes, trees.starts, shares, stored, config.importance_exponent, indices, weights)
        return Draw(indices.ravel(), self._firsts, weights[self._tree_of])

    def update(self, indices: Ints, errors: Floats32) -> None:
        """Give the drawn transitions their new priorities in every tree; see `Sampler.update`."""
        config, trees = self._config, self._trees
        given = (self._highest, self._magnitude, config.priority_floor, config.priority_exponent)
        if self._hierarchical:
            shift, room = config.priority == "shift", np.empty((1, indices.size // len(trees.nodes)))
            _update_levels(trees.nodes, trees.starts, indices, errors, *given, self._of_option, shift, room)
        else:
            _update_mean(trees.nodes, trees.starts, indices, errors, *given, np.empty((1, indices.size)))

    def state(self) -> State:
        """Return generator, trees, highest priorities and magnitudes; see `hhrl_agents.stateful.Stateful`."""
        return {**save_stream(self._stream), **{name: array.copy() for name, array in self._memory().items()}}

    def restore(self, state: State) -> None:
        """Take up a state; see `hhrl_agents.stateful.Stateful`."""
        restore_stream(self._stream, state)
        for name, array in self._memory().items():
            array[...] = read(state, name, array)

    def _memory(self) -> State:
        kept = {"trees": self._trees.nodes, "highest": self._highest, "magnitude": self._magnitude}
        return {**kept, "of_option": self._of_option} if self._hierarchical else kept


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
def _update_mean(
    nodes: Floats,
    starts: Ints,
    indices: Ints,
    errors: Floats32,
    highest: Floats,
    magnitude: Floats,
    floor: float,
    exponent: float,
    priorities: Floats,
) -> None:
    """Give the transitions `indices` [M] the mean of their scaled errors [levels, M] as priorities.

    priorities: room for them, float64 [1, M].
    """
    levels, size = errors.shape
    for m in range(size):
        priorities[0, m] = 0.0
    for level in range(levels):
        scale = _magnitude_with(errors, level, 0, size, magnitude)
        for m in range(size):
            priorities[0, m] += abs(np.float64(errors[level, m])) / scale
    for m in range(size):
        priorities[0, m] /= levels
    _assign(nodes, starts, indices, highest, floor, exponent, priorities)


@kernel
def _update_levels(
    nodes: Floats,
    starts: Ints,
    indices: Ints,
    errors: Floats32,
    highest: Floats,
    magnitude: Floats,
    floor: float,
    exponent: float,
    of_option: Floats,
    shift: bool,
    priorities: Floats,
) -> None:
    """Give each level's part of the transitions `indices` [levels K] priorities in its tree, by its errors there.

    errors: float32 [levels, levels K]; of_option: p^o of all transitions; priorities: room for K, float64 [1, K].
    """
    size = priorities.shape[1]
    for level in range(nodes.shape[0]):
        begin = level * size
        scale = 1.0 if shift else _magnitude_with(errors, level, begin, size, magnitude)
        lowest = np.inf
        for k in range(size):
            error = abs(np.float64(errors[level, begin + k])) / scale
            if level == OPTION:
                of_option[indices[begin + k]] = error
            else:
                error -= of_option[indices[begin + k]]
            priorities[0, k] = error
            lowest = min(lowest, error)
        lowest = lowest if shift and level == ACTION else 0.0
        for k in range(size):
            priorities[0, k] = max(priorities[0, k] - lowest, 0.0)
        tree = nodes[level : level + 1]
        own = indices[begin : begin + size]
        _assign(tree, starts, own, highest[level : level + 1], floor, exponent, priorities)


@spliced
def _assign(
    nodes: Floats, starts: Ints, indices: Ints, highest: Floats, floor: float, exponent: float, priorities: Floats
) -> None:
    """Give transitions these priorities, float64 [1, K], in the one tree of `nodes`, with floor and exponent."""
    for k in range(priorities.shape[1]):
        priorities[0, k] += floor
    raise_all(priorities, exponent)
    for k in range(priorities.shape[1]):
        highest[0] = max(highest[0], priorities[0, k])
    assign(nodes, starts, indices, priorities)


@spliced
def _magnitude_with(errors: Floats32, level: int, begin: int, size: int, magnitude: Floats) -> float:
    """Return a level's running magnitude, these errors in it; the first ones are the first magnitude."""
    mean = 0.0
    for k in range(size):
        mean += abs(np.float64(errors[level, begin + k]))
    mean /= size
    rate = 1.0 if magnitude[level] == 0.0 else SCALE_RATE
    magnitude[level] += rate * (mean - magnitude[level])
    scale: float = max(magnitude[level], _SMALLEST)
    return scale


def make_sampler(method: Method, stream: np.random.Generator, levels: int, capacity: int) -> Sampler:
    """Return the sampler that the method asks for, for a buffer of `capacity` transitions and `levels` networks."""
    if method.replay == "uniform":
        return UniformSampler(stream, levels, method.config.batch_size)
    hierarchical = method.replay == "hierarchical" and levels > 1  # of one level the hierarchy is the plain one
    return PrioritisedSampler(stream, levels, capacity, method.config, hierarchical=hierarchical)
