"""Memory as running averages of what was observed: a filter against noise, and a sense of what came before."""

from collections.abc import Sequence

import numpy as np

from hhrl_envs.arrays import Flags, Floats32
from hhrl_envs.observation import SIZE
from hhrl_envs.state import State, read


class Traces:
    """Exponential traces of every row's observations, one for each rate.

    A trace moves by the share `rate` of the way to each observation (0.1 remembers about ten steps), and begins an
    episode at its first one. Without rates there is nothing to remember.
    """

    def __init__(self, rates: Sequence[float]) -> None:
        self._rates = np.array(rates, np.float32)[:, None]
        self._fresh = np.ones(0, np.bool_)
        self._traces = np.zeros((0, len(rates), SIZE), np.float32)

    def state(self) -> State:
        """Return the traces and which rows are yet to begin one; see `hhrl_agents.stateful.Stateful`."""
        return {"traces": self._traces.copy(), "fresh": self._fresh.copy()}

    def restore(self, state: State) -> None:
        """Take up a state; see `hhrl_agents.stateful.Stateful`."""
        self._traces = read(state, "traces", self._traces).copy()
        self._fresh = read(state, "fresh", self._fresh).copy()

    def begin(self, mask: Flags) -> None:
        """Forget the rows of `mask`, bool [B]; all rows if their number changes."""
        if len(mask) != len(self._fresh):
            self._fresh = np.ones(len(mask), np.bool_)
            self._traces = np.zeros((len(mask), *self._traces.shape[1:]), np.float32)
        self._fresh |= mask

    def observe(self, observations: Floats32, rows: Flags | None = None) -> Floats32:
        """Return the observations [B, SIZE] with their traces beside them, float32 [B, SIZE (1 + rates)].

        rows: bool [B], which rows are observed; the traces of the others stay. None is all.
        """
        if not self._rates.size:
            return observations
        if len(observations) != len(self._fresh):
            self.begin(np.ones(len(observations), np.bool_))
        rates = np.where(self._fresh[:, None, None], np.float32(1.0), self._rates)
        if rows is not None:
            rates = np.where(rows[:, None, None], rates, np.float32(0.0))
        self._traces += rates * (observations[:, None] - self._traces)
        self._fresh = self._fresh & ~rows if rows is not None else np.zeros_like(self._fresh)
        return np.concatenate((observations[:, None], self._traces), axis=1).reshape(len(observations), -1)
