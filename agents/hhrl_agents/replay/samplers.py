"""Which transitions a gradient step learns from: uniformly drawn ones, or prioritised ones, plain or hierarchical."""

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from hhrl_agents.agent import ACTION, OPTION
from hhrl_agents.methods.configs import DoubleDQNConfig
from hhrl_agents.methods.method import Method
from hhrl_agents.replay.sum_tree import SumTrees
from hhrl_agents.seeding import restore_streams, save_streams, uniforms
from hhrl_agents.stateful import Stateful
from hhrl_envs.arrays import Floats, Floats32, Ints
from hhrl_envs.state import State, read

SCALE_RATE = 0.01
"""Rate at which the running magnitude of a level's TD error follows the batches."""


class Draw(NamedTuple):
    """Mini-batches of K transitions for each of E seeds, one or one for each level, side by side.

    indices: int64 [E, M], M = K or levels x K; parts: for each level where its mini-batch lies in the M; weights: for
    each level what its squared errors are multiplied with, float32 [E, 1, K].
    """

    indices: Ints
    parts: Sequence[slice]
    weights: Sequence[Floats32]


class Sampler(Stateful, Protocol):
    """What a learner asks of a way to sample the replay buffer."""

    def added(self, indices: Ints) -> None:
        """Return nothing; take note that every seed's transitions at `indices` [E, n] are new; -1 is none."""

    def draw(self, stored: Ints) -> Draw:
        """Return mini-batches from each seed's `stored` transitions, int64 [E]."""

    def update(self, indices: Ints, errors: Floats) -> None:
        """Return nothing; take note of the drawn transitions' absolute TD errors, [levels, E, M]."""


class UniformSampler:
    """Every stored transition is drawn with the same chance; all levels learn from the same mini-batch."""

    def __init__(self, streams: Sequence[np.random.Generator], levels: int, batch_size: int) -> None:
        self._streams = streams
        self._batch_size = batch_size
        self._parts = [slice(0, batch_size)] * levels
        self._weights = [np.ones((len(streams), 1, batch_size), np.float32)] * levels

    def added(self, indices: Ints) -> None:
        """Return nothing; see `Sampler.added`."""

    def draw(self, stored: Ints) -> Draw:
        """Return `batch_size` transitions for each seed, all of weight 1; see `Sampler.draw`."""
        indices = (uniforms(self._streams, self._batch_size) * stored[:, None]).astype(np.int64)
        return Draw(indices, self._parts, self._weights)

    def update(self, indices: Ints, errors: Floats) -> None:
        """Return nothing; see `Sampler.update`."""

    def state(self) -> State:
        """Return the generators; see `hhrl_agents.stateful.Stateful`."""
        return save_streams(self._streams)

    def restore(self, state: State) -> None:
        """Return nothing; see `hhrl_agents.stateful.Stateful`."""
        restore_streams(self._streams, state)


class PrioritizedSampler:
    """Prioritised experience replay: sum trees over one buffer, each with a mini-batch P ~ p^alpha of its own.

    `trees` = 1 is the plain one (Schaul et al., 2016), whose mini-batch all levels learn from; with a tree for each
    level it is the hierarchical one (Algorithm 3). A level's loss weighs its mini-batch by [N P]^-beta / max, N the
    number of stored transitions. The TD errors of all levels are evaluated on every drawn transition, so each gets all
    its priorities; new transitions get the highest so far. With every error divided by its level's running magnitude
    the plain priority is the levels' mean error, and the hierarchical ones (Eq. (pri)) are p^o = |delta_o| and
    p^a = max(|delta_a| - |delta_o|, 0). `config.priority` = "shift" is the paper's literal p^a, the undivided
    |delta_a| - |delta_o| minus its minimum over the mini-batches.
    """

    def __init__(
        self, streams: Sequence[np.random.Generator], levels: int, trees: int, capacity: int, config: DoubleDQNConfig
    ) -> None:
        self._streams, self._config, self._num_trees = streams, config, trees
        size = config.batch_size
        self._parts = [slice(level % trees * size, (level % trees + 1) * size) for level in range(levels)]
        self._strata = np.arange(size)
        self._trees = SumTrees(trees * len(streams), capacity)
        self._highest = np.ones((trees, len(streams)))
        self._magnitude = np.zeros((levels, len(streams)))

    def added(self, indices: Ints) -> None:
        """Return nothing; give the new transitions the highest priority; see `Sampler.added`."""
        self._trees.assign(np.tile(indices, (self._num_trees, 1)), self._highest.reshape(-1, 1))

    def draw(self, stored: Ints) -> Draw:
        """Return each tree's mini-batch, one beside the other; see `Sampler.draw`."""
        seeds, size = len(self._streams), self._config.batch_size
        uniform = uniforms(self._streams, self._num_trees, size).swapaxes(0, 1)
        indices = self._trees.find(((self._strata + uniform) / size).reshape(-1, size))
        chances = self._trees.priorities(indices) / self._trees.totals[:, None]
        weights = (np.tile(stored, self._num_trees)[:, None] * chances) ** -self._config.importance_exponent
        weights = (weights / weights.max(-1, keepdims=True)).astype(np.float32).reshape(-1, seeds, 1, size)
        side_by_side = indices.reshape(-1, seeds, size).swapaxes(0, 1).reshape(seeds, -1)
        return Draw(side_by_side, self._parts, [weights[level % len(weights)] for level in range(len(self._parts))])

    def update(self, indices: Ints, errors: Floats) -> None:
        """Return nothing; give the drawn transitions their new priorities in every tree; see `Sampler.update`."""
        priorities = (self._priorities(errors) + self._config.priority_floor) ** self._config.priority_exponent
        np.maximum(self._highest, priorities.max(-1), out=self._highest)
        self._trees.assign(np.tile(indices, (self._num_trees, 1)), priorities.reshape(-1, indices.shape[1]))

    def state(self) -> State:
        """Return generators, trees, highest priorities and magnitudes; see `hhrl_agents.stateful.Stateful`."""
        return {**save_streams(self._streams), **{name: array.copy() for name, array in self._memory().items()}}

    def restore(self, state: State) -> None:
        """Return nothing; see `hhrl_agents.stateful.Stateful`."""
        restore_streams(self._streams, state)
        for name, array in self._memory().items():
            array[...] = read(state, name, array)

    def _memory(self) -> State:
        return {"trees": self._trees.nodes, "highest": self._highest, "magnitude": self._magnitude}

    def _priorities(self, errors: Floats) -> Floats:
        """Return the priorities [trees, E, M] of absolute errors [levels, E, M], before floor and exponent."""
        if self._num_trees > 1 and self._config.priority == "shift":
            gap = errors[ACTION] - errors[OPTION]
            return np.stack((errors[OPTION], gap - gap.min(-1, keepdims=True)))
        scaled = errors / self._scale(errors)
        if self._num_trees > 1:
            return np.stack((scaled[OPTION], np.maximum(scaled[ACTION] - scaled[OPTION], 0.0)))
        mean: Floats = scaled.mean(axis=0, keepdims=True)
        return mean

    def _scale(self, errors: Floats) -> Floats:
        """Return each level's running magnitude with these errors in it, [levels, E, 1]."""
        rate = np.where(self._magnitude == 0.0, 1.0, SCALE_RATE)
        self._magnitude += rate * (errors.mean(-1) - self._magnitude)
        return np.maximum(self._magnitude, 1e-12)[..., None]


def make_sampler(method: Method, streams: Sequence[np.random.Generator], levels: int, capacity: int) -> Sampler:
    """Return the sampler that the method asks for, for a buffer of `capacity` transitions and `levels` networks."""
    if method.replay == "uniform":
        return UniformSampler(streams, levels, method.config.batch_size)
    trees = levels if method.replay == "hierarchical" else 1
    return PrioritizedSampler(streams, levels, trees, capacity, method.config)
