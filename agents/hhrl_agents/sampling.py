"""Which transitions a gradient step learns from: uniformly drawn ones, or hierarchically prioritised ones (HPER)."""

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from hhrl_agents.base import Float32Array, FloatArray, IntArray
from hhrl_agents.methods import LearnerConfig
from hhrl_agents.seeding import uniforms
from hhrl_agents.sum_tree import assign, empty_trees, find

LEVELS = 2
SCALE_RATE = 0.01
"""Rate at which the running magnitude of a level's TD error follows the batches."""


class Draw(NamedTuple):
    """A mini-batch of K transitions for each seed.

    indices: int64 [E, K]; weights: of each level's squared errors, float32, broadcastable to [levels, E, K].
    """

    indices: IntArray
    weights: Float32Array


class Sampler(Protocol):
    """What a learner asks of a way to sample the replay buffer."""

    def added(self, indices: IntArray) -> None:
        """Return nothing; take note that every seed's transitions at `indices` [n] are new."""

    def draw(self, stored: int) -> Draw:
        """Return a mini-batch from `stored` transitions."""

    def update(self, indices: IntArray, errors: Float32Array) -> None:
        """Return nothing; take note of the drawn transitions' absolute TD errors, [levels, E, K]."""


class UniformSampler:
    """Every stored transition is drawn with the same chance; both levels learn from the same mini-batch."""

    def __init__(self, streams: Sequence[np.random.Generator], batch_size: int) -> None:
        self._streams = streams
        self._batch_size = batch_size
        self._weights = np.ones((1, 1, batch_size), np.float32)

    def added(self, indices: IntArray) -> None:
        """Return nothing; see `Sampler.added`."""

    def draw(self, stored: int) -> Draw:
        """Return `batch_size` transitions for each seed, all of weight 1; see `Sampler.draw`."""
        return Draw((uniforms(self._streams, self._batch_size) * stored).astype(np.int64), self._weights)

    def update(self, indices: IntArray, errors: Float32Array) -> None:
        """Return nothing; see `Sampler.update`."""


class HierarchicalPrioritizedSampler:
    """Hierarchical prioritised experience replay (Eq. (pri), Algorithm 3): two sum trees over one buffer.

    The option level's mini-batch is drawn with P ~ (p^o)^alpha, the action level's with P ~ (p^a)^alpha; a draw holds
    both, first the option level's, and each level's loss weighs its own half by [N P]^-beta / max, N the number of
    stored transitions. Both levels' TD errors are evaluated on both halves, so every drawn transition gets both
    priorities: p^o = |delta_o| and p^a = max(|delta_a| - |delta_o|, 0), each error divided by its level's running
    magnitude (`priority="shift"`: the raw |delta_a| - |delta_o| minus its minimum over the batch). New transitions get
    the highest priority so far.
    """

    def __init__(self, streams: Sequence[np.random.Generator], capacity: int, config: LearnerConfig) -> None:
        self._streams = streams
        self._config = config
        self._trees = empty_trees(LEVELS * len(streams), capacity)
        self._highest = np.ones((LEVELS, len(streams)))
        self._magnitude = np.zeros((LEVELS, len(streams)))
        self._half = np.arange(config.batch_size)

    def added(self, indices: IntArray) -> None:
        """Return nothing; give the new transitions the highest priority; see `Sampler.added`."""
        shape = (len(self._trees), len(indices))
        assign(self._trees, np.broadcast_to(indices, shape), np.broadcast_to(self._highest.reshape(-1, 1), shape))

    def draw(self, stored: int) -> Draw:
        """Return the two mini-batches as one of 2 `batch_size` transitions; see `Sampler.draw`."""
        seeds, size = len(self._streams), self._config.batch_size
        shares = (self._half + uniforms(self._streams, LEVELS, size).swapaxes(0, 1)) / size
        indices = find(self._trees, shares.reshape(-1, size))
        weights = self._importance(indices, stored).reshape(LEVELS, seeds, size)
        halves = np.zeros((LEVELS, seeds, LEVELS, size), np.float32)
        for level in range(LEVELS):
            halves[level, :, level] = weights[level]
        both = indices.reshape(LEVELS, seeds, size).swapaxes(0, 1)
        return Draw(both.reshape(seeds, -1), halves.reshape(LEVELS, seeds, -1))

    def update(self, indices: IntArray, errors: Float32Array) -> None:
        """Return nothing; give the drawn transitions their new priorities at both levels; see `Sampler.update`."""
        priorities = self._priorities(errors.astype(np.float64)) ** self._config.priority_exponent
        np.maximum(self._highest, priorities.max(-1), out=self._highest)
        assign(self._trees, np.tile(indices, (LEVELS, 1)), priorities.reshape(len(self._trees), -1))

    def _importance(self, indices: IntArray, stored: int) -> FloatArray:
        leaves = self._trees.shape[1] // 2
        chances = np.take_along_axis(self._trees, leaves + indices, axis=1) / self._trees[:, 1:2]
        weights = (stored * chances) ** -self._config.importance_exponent
        normalised: FloatArray = weights / weights.max(-1, keepdims=True)
        return normalised

    def _priorities(self, errors: FloatArray) -> FloatArray:
        if self._config.priority == "shift":
            gap = errors[1] - errors[0]
            return np.stack((errors[0], gap - gap.min(-1, keepdims=True))) + self._config.priority_floor
        batch = errors.mean(-1)
        self._magnitude += np.where(self._magnitude == 0.0, 1.0, SCALE_RATE) * (batch - self._magnitude)
        option, action = errors / np.maximum(self._magnitude, 1e-12)[..., None]
        return np.stack((option, np.maximum(action - option, 0.0))) + self._config.priority_floor
