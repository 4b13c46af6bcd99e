"""The replay buffer: the last transitions of E seeds, each a packed row of numbers, so that one gather fetches all."""

from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor

from hhrl_agents.agent import NO_ACTION
from hhrl_envs.arrays import Floats, Floats32, Ints
from hhrl_envs.state import State, read


class Transitions(NamedTuple):
    """One step of n vehicles for each of E seeds.

    observations, next_observations: float32 [E, n, 11]; options, actions: int64 [E, n], `NO_ACTION` where a vehicle
    whose episode has ended waits for the others; rewards: [E, n, 2], a column for each level; discounts: [E, n], gamma,
    or 0 where the episode terminated.
    """

    observations: Floats32
    options: Ints
    actions: Ints
    rewards: Floats
    discounts: Floats
    next_observations: Floats32


class Batch(NamedTuple):
    """Mini-batches of M transitions for each of E seeds, as columns: each is one [E, features, M].

    observations, next_observations: [E, 11, M]; options, actions (int64), option_rewards, action_rewards, discounts:
    [E, 1, M].
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
        self._rows = torch.zeros((num_seeds, self.capacity, 2 * features + 5), device=device)
        self._first_rows = np.arange(num_seeds)[:, None] * self.capacity

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
        rewards = self._rows[:, : self.stored.max(), 2 * self._features : 2 * self._features + 2]
        largest: Floats = rewards.abs().amax((1, 2)).cpu().double().numpy()
        return largest

    def state(self) -> State:
        """Return what is stored, and where the next transition belongs; see `hhrl_agents.stateful.Stateful`."""
        rows = self._rows[:, : self.stored.max()].cpu().numpy().copy()
        return {"rows": rows, "stored": self.stored.copy(), "position": self._position.copy()}

    def restore(self, state: State) -> None:
        """Return nothing; see `hhrl_agents.stateful.Stateful`."""
        self.stored = np.clip(read(state, "stored", self.stored), 0, self.capacity)
        self._position = read(state, "position", self._position) % self.capacity
        stored = self._rows[:, : self.stored.max()]
        stored.copy_(torch.from_numpy(read(state, "rows", stored.cpu().numpy())))

    def gather(self, indices: Ints) -> Batch:
        """Return the transitions at `indices`, int64 [E, M], each column from its seed's own ring."""
        flat = torch.from_numpy((indices + self._first_rows).reshape(-1)).to(self._rows.device)
        rows = self._rows.view(-1, self._rows.shape[2]).index_select(0, flat).view(*indices.shape, -1).transpose(1, 2)
        following, rewards = self._features, 2 * self._features
        choices = rows[:, rewards + 3 :].long()
        return Batch(
            observations=rows[:, :following],
            options=choices[:, :1],
            actions=choices[:, 1:],
            option_rewards=rows[:, rewards : rewards + 1],
            action_rewards=rows[:, rewards + 1 : rewards + 2],
            discounts=rows[:, rewards + 2 : rewards + 3],
            next_observations=rows[:, following:rewards],
        )
