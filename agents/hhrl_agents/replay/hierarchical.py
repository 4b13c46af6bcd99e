"""Prioritised experience replay: plain, and hierarchical with priorities for each level (Algorithm 3)."""

from collections.abc import Sequence

import numpy as np

from hhrl_agents.agent import ACTION, OPTION
from hhrl_agents.methods.configs import DoubleDQNConfig
from hhrl_agents.methods.method import Method
from hhrl_agents.replay.buffer import Draw, Sampler, UniformSampler
from hhrl_agents.replay.sum_tree import SumTrees
from hhrl_agents.seeding import restore_streams, save_streams, uniforms
from hhrl_envs.arrays import Floats, Ints
from hhrl_envs.state import State, read

SCALE_RATE = 0.01
"""Rate at which the running magnitude of a level's TD error follows the batches."""


class PrioritisedSampler:
    """Plain prioritised replay (Schaul et al., 2016): one mini-batch, P ~ p^alpha, that all levels learn from.

    A level's loss weighs its mini-batch by [N P]^-beta / max, N the number of stored transitions. The TD errors of all
    levels are evaluated on every drawn transition, so each gets all its priorities; new transitions get the highest so
    far. With every error divided by its level's running magnitude, the priority is the mean error of the levels.

    trees: sum trees over the one buffer, each of which has priorities and a mini-batch of its own.
    """

    def __init__(
        self,
        streams: Sequence[np.random.Generator],
        levels: int,
        capacity: int,
        config: DoubleDQNConfig,
        trees: int = 1,
    ) -> None:
        self._streams, self._config, self._num_trees = streams, config, trees
        size = config.batch_size
        self._parts = [slice(level % trees * size, (level % trees + 1) * size) for level in range(levels)]
        self._strata = np.arange(size)
        self._trees = SumTrees(trees * len(streams), capacity)
        self._highest = np.ones((trees, len(streams)))
        self._magnitude = np.zeros((levels, len(streams)))

    def added(self, indices: Ints) -> None:
        """Give the new transitions the highest priority; see `Sampler.added`."""
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
        """Give the drawn transitions their new priorities in every tree; see `Sampler.update`."""
        priorities = (self._priorities(errors) + self._config.priority_floor) ** self._config.priority_exponent
        np.maximum(self._highest, priorities.max(-1), out=self._highest)
        self._trees.assign(np.tile(indices, (self._num_trees, 1)), priorities.reshape(-1, indices.shape[1]))

    def state(self) -> State:
        """Return generators, trees, highest priorities and magnitudes; see `hhrl_agents.stateful.Stateful`."""
        return {**save_streams(self._streams), **{name: array.copy() for name, array in self._memory().items()}}

    def restore(self, state: State) -> None:
        """Take up a state; see `hhrl_agents.stateful.Stateful`."""
        restore_streams(self._streams, state)
        for name, array in self._memory().items():
            array[...] = read(state, name, array)

    def _memory(self) -> State:
        return {"trees": self._trees.nodes, "highest": self._highest, "magnitude": self._magnitude}

    def _priorities(self, errors: Floats) -> Floats:
        """Return the priorities [trees, E, M] of absolute errors [levels, E, M], before floor and exponent."""
        mean: Floats = self._scaled(errors).mean(axis=0, keepdims=True)
        return mean

    def _scaled(self, errors: Floats) -> Floats:
        """Return the errors divided by their level's running magnitude, these errors in it, [levels, E, M]."""
        rate = np.where(self._magnitude == 0.0, 1.0, SCALE_RATE)
        self._magnitude += rate * (errors.mean(-1) - self._magnitude)
        return errors / np.maximum(self._magnitude, 1e-12)[..., None]


class HierarchicalSampler(PrioritisedSampler):
    """Hierarchical prioritised replay (Algorithm 3): a tree and a mini-batch for each of both levels.

    The priorities, Eq. (pri), are p^o = |delta_o| and p^a = max(|delta_a| - |delta_o|, 0) of the errors divided by
    their level's running magnitude. `config.priority` = "shift" is the paper's literal p^a, the undivided
    |delta_a| - |delta_o| minus its minimum over the mini-batches.
    """

    def __init__(
        self, streams: Sequence[np.random.Generator], levels: int, capacity: int, config: DoubleDQNConfig
    ) -> None:
        super().__init__(streams, levels, capacity, config, trees=levels)

    def _priorities(self, errors: Floats) -> Floats:
        if self._config.priority == "shift":
            gap = errors[ACTION] - errors[OPTION]
            return np.stack((errors[OPTION], gap - gap.min(-1, keepdims=True)))
        scaled = self._scaled(errors)
        return np.stack((scaled[OPTION], np.maximum(scaled[ACTION] - scaled[OPTION], 0.0)))


def make_sampler(method: Method, streams: Sequence[np.random.Generator], levels: int, capacity: int) -> Sampler:
    """Return the sampler that the method asks for, for a buffer of `capacity` transitions and `levels` networks."""
    if method.replay == "uniform":
        return UniformSampler(streams, levels, method.config.batch_size)
    if method.replay == "prioritised" or levels == 1:  # of one level the hierarchy is the plain one
        return PrioritisedSampler(streams, levels, capacity, method.config)
    return HierarchicalSampler(streams, levels, capacity, method.config)
