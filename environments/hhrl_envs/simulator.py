"""The batch simulator: B independent rows of one scenario, stepped together.

A step is: scripted traffic drives -> the ego drives -> outcomes -> reward terms -> observation. Row i with seed s gives
bit-identical trajectories whatever the batch size and whoever else is in it.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hhrl_envs import layout, observation
from hhrl_envs.compiled import Codes, Floats, Floats32, Ints, Keys, kernel
from hhrl_envs.dynamics import drive_ego
from hhrl_envs.errors import InputError
from hhrl_envs.observation import observe
from hhrl_envs.outcomes import RUNNING, judge
from hhrl_envs.profiles import describe
from hhrl_envs.rewards import reward
from hhrl_envs.scenario import Scenario
from hhrl_envs.traffic import drive_traffic
from hhrl_envs.worlds import begin


@kernel
def _reset_rows(
    chosen: NDArray[np.bool_], state: Floats, profile: Floats, seeds: Keys, episodes: Keys, feasible: NDArray[np.bool_],
    steps: Ints, ended: Codes, feasible_only: bool, c: Floats, counts: Floats, families: Floats,
) -> None:  # fmt: skip
    for i in range(chosen.size):
        if chosen[i]:
            feasible[i] = begin(state, profile, i, seeds[i], episodes[i], feasible_only, c, counts, families)
            steps[i] = 0
            ended[i] = RUNNING


@kernel
def _step(
    targets: Floats, state: Floats, profile: Floats, steps: Ints, ended: Codes, fresh: Codes, live: Floats,
    results: Floats, out: Floats32, c: Floats,
) -> None:  # fmt: skip
    rows = steps.size
    for i in range(rows):
        running = ended[i] == RUNNING
        live[i] = 1.0 if running else 0.0
        steps[i] += 1 if running else 0
    drive_traffic(state, profile, c, rows)
    drive_ego(state, targets, c, rows)
    judge(state, steps, ended, fresh, c, rows)
    reward(state, live, fresh, results, c, rows)
    observe(state, out, c, rows)


class Simulator:
    """A batch of ``num_rows`` independent episodes of one scenario.

    The attributes below hold the outcome of the last ``reset``, ``reset_done`` or ``step`` and are overwritten by the
    next one; copy what you keep. A row whose episode has ended keeps its outcome and earns nothing until it is reset.

    Attributes:
        observations: float32 [B, 11], scaled; see ``hhrl_envs.observation``.
        rewards: float64 [B], r^task.
        reward_option: float64 [B, 2], r^option if option k is the selected one.
        reward_action: float64 [B, 2], r^action if option k is the selected one.
        terms: float64 [B, 8], the signed reward terms; see ``hhrl_envs.rewards``.
        outcomes: int8 [B], ``Outcome`` codes.
        steps: int64 [B], steps done in the current episode.
        feasible: bool [B], whether any ego could succeed in the current episode.
    """

    def __init__(self, scenario: Scenario, num_rows: int) -> None:
        if num_rows < 1:
            raise InputError(f"num_rows is {num_rows}; write a number of rows, at least 1")
        self.scenario, self.num_rows = scenario, num_rows
        slots = scenario.num_vehicles + 1
        self._c, self._counts, self._families = (
            scenario.constants(),
            scenario.cumulative_counts(),
            scenario.family_table(),
        )
        self._levels = np.array(scenario.vehicle.levels)
        self._state = np.zeros((layout.STATE_SIZE, slots, num_rows))
        self._profile = np.ones((layout.PROFILE_SIZE, slots, num_rows))
        self._seeds, self._episodes = np.zeros(num_rows, np.uint64), np.zeros(num_rows, np.uint64)
        self._fresh, self._live = np.zeros(num_rows, np.int8), np.zeros(num_rows)
        self._results = np.zeros((layout.RESULTS_SIZE, num_rows))
        self._observations = np.zeros((observation.SIZE, num_rows), np.float32)
        self._ready = False
        self.outcomes, self.steps = np.zeros(num_rows, np.int8), np.zeros(num_rows, np.int64)
        self.feasible = np.zeros(num_rows, np.bool_)
        self.observations: Floats32 = self._observations.T
        self.terms: Floats = self._results[: layout.TERMS_SIZE].T
        self.rewards: Floats = self._results[layout.REWARD_TASK]
        self.reward_option: Floats = self._results[layout.REWARD_OPTION : layout.REWARD_ACTION].T
        self.reward_action: Floats = self._results[layout.REWARD_ACTION :].T

    def reset(self, seeds: ArrayLike) -> None:
        """Put every row at the start of episode 0 of its seed; ``seeds`` are integers [B] in [0, 2^64)."""
        self._seeds[:] = _as_keys(seeds, self.num_rows)
        self._episodes[:] = 0
        self._begin(np.ones(self.num_rows, np.bool_))

    def reset_done(self) -> None:
        """Put every row whose episode has ended at the start of the next episode of its seed."""
        self.next_episode(self.outcomes != RUNNING)

    def next_episode(self, chosen: NDArray[np.bool_]) -> None:
        """Put the chosen rows, bool [B], at the start of the next episode of their seeds."""
        self._require_reset()
        self._episodes[chosen] += np.uint64(1)
        if chosen.any():
            self._begin(chosen)

    def step(self, actions: ArrayLike) -> None:
        """Advance every running row by one step; ``actions`` are level indices, integers [B]."""
        self._require_reset()
        _step(
            self._targets(actions), self._state, self._profile, self.steps, self.outcomes, self._fresh, self._live,
            self._results, self._observations, self._c,
        )  # fmt: skip

    def vehicles(self, row: int) -> Floats:
        """Return position [m], speed [m/s], acceleration [m/s^2] of the vehicles of one row, float64 [V, 3].

        Slot 0 is the ego, slot k its k-th front vehicle; vehicles that the episode does not have are NaN. A position
        is that of the front bumper, 0 at the stop-line and negative before it.
        """
        picked = self._state[[layout.POSITION, layout.SPEED, layout.ACCEL], :-1, row].T.copy()
        picked[~self._present(row)] = np.nan
        return picked

    def profiles(self, row: int) -> list[dict[str, float | str]]:
        """Return the behaviour profiles of the front vehicles of one row, nearest first."""
        slots = np.flatnonzero(self._present(row))[1:]
        return [describe(self._profile[:, k, row], self.scenario.traffic.families) for k in slots]

    def key(self, row: int) -> tuple[int, int]:
        """Return (seed, episode) of one row."""
        return int(self._seeds[row]), int(self._episodes[row])

    def _present(self, row: int) -> NDArray[np.bool_]:
        present: NDArray[np.bool_] = self._state[layout.POSITION, :-1, row] < 0.5 * layout.FAR
        return present

    def _begin(self, chosen: NDArray[np.bool_]) -> None:
        _reset_rows(
            chosen, self._state, self._profile, self._seeds, self._episodes, self.feasible, self.steps, self.outcomes,
            self.scenario.feasible_only, self._c, self._counts, self._families,
        )  # fmt: skip
        if self.scenario.feasible_only and not self.feasible[chosen].all():
            raise InputError(
                f"scenario {self.scenario.id!r} draws no feasible world; widen its gaps or set feasible_only=False"
            )
        self._results[:, chosen] = 0.0
        observe(self._state, self._observations, self._c, self.num_rows)
        self._ready = True

    def _targets(self, actions: ArrayLike) -> Floats:
        chosen = np.asarray(actions)
        if chosen.shape != (self.num_rows,) or chosen.dtype.kind not in "iu":
            raise InputError(f"actions are {chosen.dtype} {chosen.shape}; write integers of shape ({self.num_rows},)")
        if chosen.min() < 0 or chosen.max() >= self._levels.size:
            bad = chosen[(chosen < 0) | (chosen >= self._levels.size)][0]
            raise InputError(f"action {bad} is not a level of {self.scenario.id!r}; write 0 to {self._levels.size - 1}")
        targets: Floats = self._levels[chosen]
        return targets

    def _require_reset(self) -> None:
        if not self._ready:
            raise InputError("the simulator has no episode yet; call reset(seeds) first")


def _as_keys(seeds: ArrayLike, num_rows: int) -> Keys:
    values = np.asarray(seeds)
    if values.shape != (num_rows,) or values.dtype.kind not in "iu" or (values.dtype.kind == "i" and values.min() < 0):
        raise InputError(f"seeds must be {num_rows} integers in [0, 2^64); got {values.dtype} {values.shape}")
    return values.astype(np.uint64)
