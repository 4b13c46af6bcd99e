"""The replay buffer: the last transitions of E seeds, each a packed row of numbers, so that one gather fetches all."""

from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor

from hhrl_agents.base import Float32Array, FloatArray, IntArray
from hhrl_envs.observation import SIZE

OPTION, ACTION = range(2)
"""The levels of the hierarchy; a flat learner has the action level alone."""

_OBSERVATION, _NEXT = slice(0, SIZE), slice(SIZE, 2 * SIZE)
_REWARDS = slice(2 * SIZE, 2 * SIZE + 2)
_DISCOUNT, _OPTION, _ACTION = range(2 * SIZE + 2, 2 * SIZE + 5)
_WIDTH = 2 * SIZE + 5


class Transitions(NamedTuple):
    """One step of n environments for each of E seeds.

    observations, next_observations: float32 [E, n, 11]; options, actions: int64 [E, n]; rewards: [E, n, 2], a column
    for each level; discounts: [E, n], gamma, or 0 where the episode terminated.
    """

    observations: Float32Array
    options: IntArray
    actions: IntArray
    rewards: FloatArray
    discounts: FloatArray
    next_observations: Float32Array


class Batch(NamedTuple):
    """A mini-batch of K transitions for each of E seeds, as tensors shaped as in `Transitions`; rewards [2, E, K]."""

    observations: Tensor
    options: Tensor
    actions: Tensor
    rewards: Tensor
    discounts: Tensor
    next_observations: Tensor


class ReplayBuffer:
    """A ring of `capacity` transitions a seed, rounded down to whole steps of `n_envs` environments.

    All seeds step together, so one position and one count (`stored`) serve them all.
    """

    def __init__(self, num_seeds: int, n_envs: int, capacity: int) -> None:
        self.capacity = capacity - capacity % n_envs
        self.stored = 0
        self._position = 0
        self._rows = np.zeros((num_seeds, self.capacity, _WIDTH), np.float32)
        self._table = torch.from_numpy(self._rows).view(-1, _WIDTH)
        self._first_rows = np.arange(num_seeds)[:, None] * self.capacity

    def add(self, step: Transitions) -> IntArray:
        """Return the indices [n] at which every seed's n transitions are now stored, in place of the oldest."""
        count = step.actions.shape[1]
        indices = np.arange(self._position, self._position + count)
        rows = self._rows[:, self._position : self._position + count]
        rows[..., _OBSERVATION] = step.observations
        rows[..., _NEXT] = step.next_observations
        rows[..., _REWARDS] = step.rewards
        rows[..., _DISCOUNT] = step.discounts
        rows[..., _OPTION] = step.options
        rows[..., _ACTION] = step.actions
        self._position = (self._position + count) % self.capacity
        self.stored = min(self.stored + count, self.capacity)
        return indices

    def gather(self, indices: IntArray) -> Batch:
        """Return the transitions at `indices`, int64 [E, K], each row from its seed's own ring."""
        flat = torch.from_numpy((indices + self._first_rows).reshape(-1))
        rows = self._table.index_select(0, flat).view(*indices.shape, _WIDTH)
        choices = rows[..., _OPTION:].long()
        return Batch(
            observations=rows[..., _OBSERVATION],
            options=choices[..., 0],
            actions=choices[..., 1],
            rewards=rows[..., _REWARDS].permute(2, 0, 1),
            discounts=rows[..., _DISCOUNT],
            next_observations=rows[..., _NEXT],
        )
