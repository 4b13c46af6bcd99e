"""Epsilon-greedy exploration that holds what it tries for a while."""

import numpy as np

from hhrl_agents.seeding import restore_stream, save_stream
from hhrl_envs import Scenario
from hhrl_envs.arrays import Ints
from hhrl_envs.state import State, read

GREEDY = -1
"""What `Explorer.draw` returns where the greedy choice is to be made."""


class Explorer:
    """Random choices of one level for n vehicles, every one held for 1 to `longest` steps.

    Steps of 0.1 s are short: choices that change at every step cancel out, and the ego goes nowhere. Holding them is
    the temporally extended epsilon-greedy exploration of Dabney, Ostrovski and Barreto (2021), with uniform
    durations; `longest` = 1 is plain epsilon-greedy. Explorers may share a stream.
    """

    def __init__(self, stream: np.random.Generator, vehicles: int, choices: Ints, longest: int) -> None:
        self._stream = stream
        self._choices = choices
        self._longest = longest
        self._tried: Ints = np.zeros(vehicles, np.int64)
        self._left: Ints = np.zeros_like(self._tried)

    def draw(self, epsilon: float) -> Ints:
        """Return for each vehicle the choice to try or `GREEDY`, int64 [n]; a share `epsilon` of steps tries."""
        start, choice, duration = self._stream.random((len(self._tried), 3)).T
        starts = (self._left == 0) & (start < self._rate(epsilon))
        self._tried = np.where(starts, self._choices[(choice * len(self._choices)).astype(np.int64)], self._tried)
        self._left = np.where(starts, 1 + (duration * self._longest).astype(np.int64), self._left)
        tried = np.where(self._left > 0, self._tried, GREEDY)
        self._left = np.maximum(self._left - 1, 0)
        return tried

    def state(self) -> State:
        """Return the generator and what is being held for how long; see `hhrl_agents.stateful.Stateful`."""
        return {**save_stream(self._stream), "tried": self._tried.copy(), "left": self._left.copy()}

    def restore(self, state: State) -> None:
        """Take up a state; see `hhrl_agents.stateful.Stateful`."""
        restore_stream(self._stream, state)
        self._tried = read(state, "tried", self._tried).copy()
        self._left = read(state, "left", self._left).copy()

    def _rate(self, epsilon: float) -> float:
        """Return the chance to start a trial at a free step that makes trials a share `epsilon` of all steps."""
        duration = (1 + self._longest) / 2
        return epsilon / (epsilon + duration * (1.0 - epsilon))


def level_choices(scenario: Scenario) -> dict[str, Ints]:
    """Return what each level chooses from: the options that the scenario has, and its actions."""
    return {"option": np.flatnonzero(scenario.option_mask), "action": np.arange(scenario.num_actions)}
