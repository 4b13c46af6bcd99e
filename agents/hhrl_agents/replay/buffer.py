"""The replay buffer: the last transitions of a seed, and how they are drawn uniformly.

A transition is a packed row of numbers: both states, a reward for each level, what discounts the next state's value,
the option and the action.
"""

from typing import NamedTuple, Protocol

import numpy as np

from hhrl_agents.agent import NO_ACTION
from hhrl_agents.seeding import restore_stream, save_stream
from hhrl_agents.stateful import Stateful
from hhrl_envs.arrays import Floats, Floats32, Ints
from hhrl_envs.state import State, count, read, read_count

REWARDS, DISCOUNT, OPTIONS, ACTIONS, NUMBERS = 0, 2, 3, 4, 5
"""Where behind both states the numbers of a transition lie: the rewards of both levels first; and how many they are."""


class Transitions(NamedTuple):
    """One step of n vehicles.

    observations, next_observations: float32 [n, features]; options, actions: int64 [n], `NO_ACTION` where a vehicle
    whose episode has ended waits for the others; rewards: [n, levels]; discounts: [n], gamma, or 0 where the episode
    terminated.
    """

    observations: Floats32
    options: Ints
    actions: Ints
    rewards: Floats
    discounts: Floats
    next_observations: Floats32


class ReplayBuffer:
    """A ring of `capacity` transitions.

    rows: float32 [capacity, 2 features + NUMBERS]; stored: how many of them are filled.
    """

    def __init__(self, capacity: int, features: int) -> None:
        self.capacity = capacity
        self.stored = self._position = 0
        self._features = features
        self.rows: Floats32 = np.zeros((capacity, 2 * features + NUMBERS), np.float32)

    def add(self, step: Transitions) -> Ints:
        """Return the indices [n] at which the transitions are now stored, in place of the oldest ones.

        Those of vehicles that wait are not: their index is -1.
        """
        acted = step.actions != NO_ACTION
        places = (self._position + acted.cumsum() - 1) % self.capacity
        columns = (step.rewards, step.discounts[:, None], step.options[:, None], step.actions[:, None])
        rows = np.concatenate((step.observations, step.next_observations, *columns), axis=1, dtype=np.float32)
        self.rows[places[acted]] = rows[acted]
        added = int(acted.sum())
        self._position = (self._position + added) % self.capacity
        self.stored = min(self.stored + added, self.capacity)
        return np.where(acted, places, -1)

    def next_observations(self, indices: Ints) -> Floats32:
        """Return what the networks read of the states that these transitions led to, float32 [M, features]."""
        return self.rows[indices, self._features : 2 * self._features]

    def largest_reward(self) -> float:
        """Return the largest absolute reward of any level that is stored."""
        first = 2 * self._features + REWARDS
        return float(np.abs(self.rows[: self.stored, first : first + DISCOUNT]).max(initial=0.0))

    def state(self) -> State:
        """Return what is stored, and where the next transition belongs; see `hhrl_agents.stateful.Stateful`."""
        return {
            "rows": self.rows[: self.stored].copy(),
            "stored": count(self.stored),
            "position": count(self._position),
        }

    def restore(self, state: State) -> None:
        """Take up a state; see `hhrl_agents.stateful.Stateful`."""
        self.stored = min(max(read_count(state, "stored"), 0), self.capacity)
        self._position = read_count(state, "position") % self.capacity
        self.rows[: self.stored] = read(state, "rows", self.rows[: self.stored])


class Draw(NamedTuple):
    """Mini-batches of K transitions, one or one for each level, side by side.

    indices: int64 [M], M = K or levels x K; firsts: int64 [levels], where in the M each level's mini-batch begins;
    weights: float32 [levels, K], what squared errors are multiplied with.
    """

    indices: Ints
    firsts: Ints
    weights: Floats32


class Sampler(Stateful, Protocol):
    """What a learner asks of a way to sample the replay buffer."""

    def added(self, indices: Ints) -> None:
        """Take note that the transitions at `indices` [n] are new; -1 is none."""

    def draw(self, stored: int) -> Draw:
        """Return mini-batches from the `stored` transitions."""

    def update(self, indices: Ints, errors: Floats32) -> None:
        """Take note of TD errors, float32 [levels, M]: of each level those of the mini-batch that it has drawn."""


class UniformSampler:
    """Every stored transition is drawn with the same chance; all levels learn from the same mini-batch."""

    def __init__(self, stream: np.random.Generator, levels: int, batch_size: int) -> None:
        self._stream = stream
        self._firsts = np.zeros(levels, np.int64)
        self._weights = np.ones((levels, batch_size), np.float32)

    def added(self, indices: Ints) -> None:
        """Do nothing: all transitions are alike."""

    def draw(self, stored: int) -> Draw:
        """Return `batch_size` transitions, all of weight 1; see `Sampler.draw`."""
        indices = (self._stream.random(self._weights.shape[1]) * stored).astype(np.int64)
        return Draw(indices, self._firsts, self._weights)

    def update(self, indices: Ints, errors: Floats32) -> None:
        """Do nothing: errors do not matter."""

    def state(self) -> State:
        """Return the generator; see `hhrl_agents.stateful.Stateful`."""
        return save_stream(self._stream)

    def restore(self, state: State) -> None:
        """Take up a state; see `hhrl_agents.stateful.Stateful`."""
        restore_stream(self._stream, state)
