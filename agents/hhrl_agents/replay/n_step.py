"""Multi-step returns: several steps of reward before a target bootstraps."""

from collections import deque

import numpy as np

from hhrl_agents.replay.buffer import Transitions
from hhrl_agents.stateful import below, prefixed
from hhrl_envs.arrays import Flags
from hhrl_envs.state import State, count, read_count


class MultiStep:
    """Joins the last `n_steps` steps of every environment to one transition.

    From R = r_1 + gamma r_2 + ... + gamma^(m-1) r_m and the state after m steps, where m is `n_steps`, or less where
    the episode ends before. Exploratory steps are not corrected for, as in Rainbow (Hessel et al., 2018).
    """

    def __init__(self, n_steps: int) -> None:
        self._n_steps = n_steps
        self._window: deque[tuple[Transitions, Flags]] = deque()

    def push(self, step: Transitions, ended: Flags) -> Transitions | None:
        """Return the transition that begins `n_steps` - 1 steps ago, none as long as there are too few.

        ended: bool [n], where the step was an episode's last.
        """
        self._window.append((step, ended))
        if len(self._window) < self._n_steps:
            return None
        joined, done = self._window.popleft()
        for later, later_ended in self._window:
            joined = _followed_by(joined, later, ~done)
            done = done | later_ended
        return joined

    def state(self) -> State:
        """Return the steps that wait to be joined, oldest first; see `hhrl_agents.stateful.Stateful`."""
        steps = {
            str(index): {name: array.copy() for name, array in (*step._asdict().items(), ("ended", ended))}
            for index, (step, ended) in enumerate(self._window)
        }
        return {**prefixed(steps), "length": count(len(self._window))}

    def restore(self, state: State) -> None:
        """Take up a state; see `hhrl_agents.stateful.Stateful`."""
        self._window.clear()
        for index in range(read_count(state, "length")):
            arrays = dict(below(state, str(index)))
            ended = arrays.pop("ended")
            self._window.append((Transitions(**arrays), ended))


def _followed_by(joined: Transitions, later: Transitions, goes_on: Flags) -> Transitions:
    each = goes_on[..., None]
    return joined._replace(
        rewards=joined.rewards + np.where(each, joined.discounts[..., None] * later.rewards, 0.0),
        discounts=np.where(goes_on, joined.discounts * later.discounts, joined.discounts),
        next_observations=np.where(each, later.next_observations, joined.next_observations),
    )
