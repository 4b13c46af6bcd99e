"""The replay buffer: the last transitions of E seeds, and how they are drawn uniformly.

A transition is a packed row of numbers, so that one gather fetches all of a mini-batch.
"""

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np
import torch
from torch import Tensor

from hhrl_agents.agent import ACTION, LEVELS, NO_ACTION, OPTION
from hhrl_agents.seeding import restore_streams, save_streams, uniforms
from hhrl_agents.stateful import Stateful
from hhrl_envs.arrays import Floats, Floats32, Ints
from hhrl_envs.state import State, read

_NUMBERS = len(LEVELS) + 3  # of a row behind both observations: a reward for each level, discount, option, action


class Transitions(NamedTuple):
    """One step of n vehicles for each of E seeds.

    observations, next_observations: float32 [E, n, features]; options, actions: int64 [E, n], `NO_ACTION` where a
    vehicle whose episode has ended waits for the others; rewards: [E, n, levels]; discounts: [E, n], gamma, or 0 where
    the episode terminated.
    """

    observations: Floats32
    options: Ints
    actions: Ints
    rewards: Floats
    discounts: Floats
    next_observations: Floats32


class MiniBatch(NamedTuple):
    """Mini-batches of M transitions for each of E seeds, as columns: each is one [E, features, M].

    observations, next_observations: [E, features, M]; options, actions (int64), option_rewards, action_rewards,
    discounts: [E, 1, M].
    """

    observations: Tensor
    options: Tensor
    actions: Tensor
    option_rewards: Tensor
    action_rewards: Tensor
    discounts: Tensor
    next_observations: Tensor


class ReplayBuffer:
    """A ring of `capacity` transitions a seed, on one device; `stored`, int64 [E], counts those of each seed."""

    def __init__(self, num_seeds: int, capacity: int, features: int, device: torch.device) -> None:
        self.capacity = capacity
        self.stored: Ints = np.zeros(num_seeds, np.int64)
        self._position: Ints = np.zeros(num_seeds, np.int64)
        self._features = features
        self._rows = torch.zeros((num_seeds, capacity, 2 * features + _NUMBERS), device=device)
        self._first_rows = np.arange(num_seeds)[:, None] * capacity

    def add(self, step: Transitions) -> Ints:
        """Return the indices [E, n] at which the transitions are now stored, in place of each seed's oldest ones.

        Those of vehicles that wait are not: their index is -1.
        """
        columns = (step.rewards, step.discounts[..., None], step.options[..., None], step.actions[..., None])
        rows = np.concatenate((step.observations, step.next_observations, *columns), axis=-1, dtype=np.float32)
        acted = step.actions != NO_ACTION
        places = (self._position[:, None] + acted.cumsum(axis=1) - 1) % self.capacity
        flat = torch.from_numpy((places + self._first_rows)[acted]).to(self._rows.device)
        self._rows.view(-1, rows.shape[2])[flat] = torch.from_numpy(rows[acted]).to(self._rows.device)
        added = acted.sum(axis=1)
        self._position = (self._position + added) % self.capacity
        self.stored = np.minimum(self.stored + added, self.capacity)
        return np.where(acted, places, -1)

    def largest_reward(self) -> Floats:
        """Return the largest absolute reward of any level that each seed's transitions hold, float64 [E]."""
        first = 2 * self._features
        rewards = self._rows[:, : self.stored.max(), first : first + len(LEVELS)]
        largest: Floats = rewards.abs().amax((1, 2)).cpu().double().numpy()
        return largest

    def state(self) -> State:
        """Return what is stored, and where the next transition belongs; see `hhrl_agents.stateful.Stateful`."""
        rows = self._rows[:, : self.stored.max()].cpu().numpy().copy()
        return {"rows": rows, "stored": self.stored.copy(), "position": self._position.copy()}

    def restore(self, state: State) -> None:
        """Take up a state; see `hhrl_agents.stateful.Stateful`."""
        self.stored = np.clip(read(state, "stored", self.stored), 0, self.capacity)
        self._position = read(state, "position", self._position) % self.capacity
        stored = self._rows[:, : self.stored.max()]
        stored.copy_(torch.from_numpy(read(state, "rows", stored.cpu().numpy())))

    def gather(self, indices: Ints) -> MiniBatch:
        """Return the transitions at `indices`, int64 [E, M], each column from its seed's own ring."""
        flat = torch.from_numpy((indices + self._first_rows).reshape(-1)).to(self._rows.device)
        rows = self._rows.view(-1, self._rows.shape[2]).index_select(0, flat).view(*indices.shape, -1).transpose(1, 2)
        following, numbers = self._features, rows[:, 2 * self._features :]
        rewards, discounts, choices = torch.split(numbers, [len(LEVELS), 1, 2], dim=1)
        options, actions = torch.split(choices.long(), 1, dim=1)
        return MiniBatch(
            observations=rows[:, :following],
            options=options,
            actions=actions,
            option_rewards=rewards[:, OPTION : OPTION + 1],
            action_rewards=rewards[:, ACTION : ACTION + 1],
            discounts=discounts,
            next_observations=rows[:, following : 2 * following],
        )


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
        """Take note that every seed's transitions at `indices` [E, n] are new; -1 is none."""

    def draw(self, stored: Ints) -> Draw:
        """Return mini-batches from each seed's `stored` transitions, int64 [E]."""

    def update(self, indices: Ints, errors: Floats) -> None:
        """Take note of the drawn transitions' absolute TD errors, [levels, E, M]."""


class UniformSampler:
    """Every stored transition is drawn with the same chance; all levels learn from the same mini-batch."""

    def __init__(self, streams: Sequence[np.random.Generator], levels: int, batch_size: int) -> None:
        self._streams = streams
        self._batch_size = batch_size
        self._parts = [slice(0, batch_size)] * levels
        self._weights = [np.ones((len(streams), 1, batch_size), np.float32)] * levels

    def added(self, indices: Ints) -> None:
        """Do nothing: all transitions are alike."""

    def draw(self, stored: Ints) -> Draw:
        """Return `batch_size` transitions for each seed, all of weight 1; see `Sampler.draw`."""
        indices = (uniforms(self._streams, self._batch_size) * stored[:, None]).astype(np.int64)
        return Draw(indices, self._parts, self._weights)

    def update(self, indices: Ints, errors: Floats) -> None:
        """Do nothing: errors do not matter."""

    def state(self) -> State:
        """Return the generators; see `hhrl_agents.stateful.Stateful`."""
        return save_streams(self._streams)

    def restore(self, state: State) -> None:
        """Take up a state; see `hhrl_agents.stateful.Stateful`."""
        restore_streams(self._streams, state)
