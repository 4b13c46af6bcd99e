"""The batch simulator: B independent rows of one scenario, stepped together.

A step is: signals switch -> traffic and ego drive, front to back -> outcomes -> reward terms -> observations ->
(auto-reset). Row i with seed s gives bit-identical trajectories whatever the batch size, the number of threads and
whoever else is in it.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hhrl_envs import layout
from hhrl_envs.batch import EPISODE, SEED, new_batch, new_results
from hhrl_envs.beginning import begin_rows
from hhrl_envs.compiled import Codes, Floats, Floats32, Ints, Keys
from hhrl_envs.errors import InputError, require_value
from hhrl_envs.outcomes import RUNNING
from hhrl_envs.profiles import describe
from hhrl_envs.scenario import Scenario
from hhrl_envs.stepping import advance_rows, bad_action


class Simulator:
    """A batch of ``num_rows`` independent episodes of one scenario, stepped by ``threads`` threads.

    The properties hold the outcome of the last ``reset``, ``next_episode``, ``reset_done`` or ``step``. Each of these
    hands out fresh arrays, so what you keep never changes (but for ``steps`` and ``feasible``, which are updated in
    place). A row whose episode has ended keeps its outcome and earns nothing until its next episode begins.

    Attributes:
        steps: int64 [B], steps done in the current episode.
        feasible: bool [B], whether any ego could succeed in the current episode.
    """

    def __init__(self, scenario: Scenario, num_rows: int, threads: int = 1) -> None:
        for name, value in (("num_rows", num_rows), ("threads", threads)):
            require_value(value >= 1, name, value, f"a number of {name.removeprefix('num_')}, at least 1")
        self.scenario, self.num_rows = scenario, num_rows
        self._batch, self._results = new_batch(scenario, 1, num_rows), new_results(1, num_rows)
        self.steps, self.feasible = self._batch.steps, self._batch.feasible
        edges = np.linspace(0, num_rows, threads + 1).astype(int).tolist()
        self._slices = list(pairwise(edges))
        self._pool = ThreadPoolExecutor(threads) if threads > 1 else None
        self._ready = False

    @property
    def observations(self) -> Floats32:
        """Scaled observations, float32 [B, 11]; see ``hhrl_envs.observation``."""
        return self._results.observations[:, 0].T

    @property
    def terms(self) -> Floats:
        """Signed reward terms, float64 [B, 8]; see ``hhrl_envs.rewards``."""
        return self._results.rewards[: layout.TERMS_SIZE, 0].T

    @property
    def rewards(self) -> Floats:
        """r^task, float64 [B]."""
        rewards: Floats = self._results.rewards[layout.REWARD_TASK, 0]
        return rewards

    @property
    def reward_option(self) -> Floats:
        """r^option if option k is the selected one, float64 [B, 2]."""
        return self._results.rewards[layout.REWARD_OPTION : layout.REWARD_ACTION, 0].T

    @property
    def reward_action(self) -> Floats:
        """r^action if option k is the selected one, float64 [B, 2]."""
        return self._results.rewards[layout.REWARD_ACTION :, 0].T

    @property
    def outcomes(self) -> Codes:
        """``Outcome`` codes, int8 [B]."""
        outcomes: Codes = self._results.ended[0]
        return outcomes

    def reset(self, seeds: ArrayLike) -> None:
        """Put every row at the start of episode 0 of its seed; ``seeds`` are integers [B] in [0, 2^64)."""
        self._batch.keys[SEED] = _as_keys(seeds, self.num_rows)
        self._batch.keys[EPISODE] = 0
        self._results = new_results(1, self.num_rows)
        self._begin(np.ones(self.num_rows, np.bool_))

    def reset_done(self) -> None:
        """Put every row whose episode has ended at the start of the next episode of its seed."""
        self.next_episode(self.outcomes != RUNNING)

    def next_episode(self, chosen: NDArray[np.bool_]) -> None:
        """Put the chosen rows, bool [B], at the start of the next episode of their seeds."""
        self._require_reset()
        self._batch.keys[EPISODE, chosen] += np.uint64(1)
        if chosen.any():
            self._results = self._results.copied()
            self._begin(chosen)

    def step(self, actions: ArrayLike, *, autoreset: bool = False) -> None:
        """Advance every running row by one step; ``actions`` are level indices, integers [B].

        With ``autoreset`` the rows that had ended before begin their next episode instead, with reward 0.
        """
        self._require_reset()
        chosen, before, after = self._checked(actions), self._results.ended, new_results(1, self.num_rows)
        self._each_slice(advance_rows, self._batch, chosen, before, after)
        self._results = after
        if autoreset:
            over = before[0] != RUNNING
            if over.any():
                self._batch.keys[EPISODE, over] += np.uint64(1)
                self._begin(over)

    def vehicles(self, row: int) -> Floats:
        """Return position [m], speed [m/s], acceleration [m/s^2] of the vehicles of one row, float64 [V, 3].

        Slot 0 is the ego, slot k its k-th front vehicle; vehicles that the episode does not have are NaN. A position is
        that of the front bumper, 0 at the first stop-line and negative before it.
        """
        picked = self._batch.state[[layout.POSITION, layout.SPEED, layout.ACCEL], :-1, row].T.copy()
        picked[~self._present(row)] = np.nan
        return picked

    def active_line(self, row: int) -> float:
        """Return the position of the ego's active stop-line in one row, in metres; ``layout.FAR`` if there is none."""
        return float(self._batch.state[layout.LINE, 0, row])

    def profiles(self, row: int) -> list[dict[str, float | str]]:
        """Return the behaviour profiles of the front vehicles of one row, nearest first."""
        slots = np.flatnonzero(self._present(row))[1:]
        return [describe(self._batch.profile[:, k, row], self.scenario.traffic.families) for k in slots]

    def key(self, row: int) -> tuple[int, int]:
        """Return (seed, episode) of one row."""
        return int(self._batch.keys[SEED, row]), int(self._batch.keys[EPISODE, row])

    def _present(self, row: int) -> NDArray[np.bool_]:
        present: NDArray[np.bool_] = self._batch.state[layout.POSITION, :-1, row] < 0.5 * layout.FAR
        return present

    def _begin(self, chosen: NDArray[np.bool_]) -> None:
        self._each_slice(begin_rows, self._batch, chosen, self._results, self.scenario.feasible_only)
        if self.scenario.feasible_only and not self.feasible[chosen].all():
            hint = "widen its gaps or set feasible_only=False"
            raise InputError(f"scenario {self.scenario.id!r} draws no feasible world; {hint}")
        self._ready = True

    def _each_slice(self, kernel: Callable[..., None], *arguments: object) -> None:
        if self._pool is None:
            kernel(*arguments, 0, self.num_rows)
        else:
            list(self._pool.map(lambda part: kernel(*arguments, *part), self._slices))

    def _checked(self, actions: ArrayLike) -> Ints:
        given, levels = np.asarray(actions), self.scenario.num_actions
        if given.shape != (self.num_rows,) or given.dtype.kind not in "iu":
            raise InputError(f"actions are {given.dtype} {given.shape}; write integers of shape ({self.num_rows},)")
        chosen = np.ascontiguousarray(given, np.int64)
        bad = bad_action(chosen, levels)
        if bad >= 0:
            raise InputError(f"action {given[bad]} is not a level of {self.scenario.id!r}; write 0 to {levels - 1}")
        return chosen

    def _require_reset(self) -> None:
        if not self._ready:
            raise InputError("the simulator has no episode yet; call reset(seeds) first")


def _as_keys(seeds: ArrayLike, num_rows: int) -> Keys:
    values = np.asarray(seeds)
    if values.shape != (num_rows,) or values.dtype.kind not in "iu" or (values.dtype.kind == "i" and values.min() < 0):
        raise InputError(f"seeds must be {num_rows} integers in [0, 2^64); got {values.dtype} {values.shape}")
    return values.astype(np.uint64)
