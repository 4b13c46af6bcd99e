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

from hhrl_envs import layout as at
from hhrl_envs import observation
from hhrl_envs.beginning import BEGUN, EPISODE, SEED, begin_rows, decide_rows
from hhrl_envs.blocks import new_memory
from hhrl_envs.blurring import blur_rows
from hhrl_envs.compiled import Codes, Flags, Floats, Floats32, Ints, Keys
from hhrl_envs.errors import InputError, require_value
from hhrl_envs.outcomes import Outcome
from hhrl_envs.profiles import describe
from hhrl_envs.scenario import Scenario
from hhrl_envs.sensing import BASE
from hhrl_envs.stepping import WAITING, advance_rows, aim

MAX_ATTEMPTS = 1000


class Simulator:
    """A batch of ``num_rows`` independent episodes of one scenario, stepped by ``threads`` threads.

    The properties hold the outcome of the last ``reset``, ``next_episode``, ``reset_done`` or ``step``. Each of these
    hands out fresh arrays, so what you keep never changes. A row whose episode has ended keeps its outcome and earns
    nothing until its next episode begins.
    """

    def __init__(self, scenario: Scenario, num_rows: int, threads: int = 1) -> None:
        for name, value in (("num_rows", num_rows), ("threads", threads)):
            require_value(value >= 1, name, value, f"a number of {name.removeprefix('num_')}, at least 1")
        self.scenario, self.num_rows = scenario, num_rows
        self._agents, self._slots = 1, scenario.num_vehicles + 1
        self._memory = new_memory(num_rows, self._slots, self._agents)
        self._keys = np.zeros((2, num_rows), np.uint64)
        self._levels, self._constants = np.array(scenario.vehicle.levels), scenario.constants(self._agents)
        self._tables = (scenario.cumulative_counts(), scenario.family_table())
        delay = 0 if scenario.sensor.perfect else scenario.sensor.delay + 1
        self._history = np.zeros((delay, len(BASE), self._agents, num_rows))
        self._pool = ThreadPoolExecutor(threads) if threads > 1 else None
        blocks = -(-num_rows // at.LANES)
        self._slices = list(pairwise(np.linspace(0, blocks, threads + 1).astype(int).tolist()))
        self._ended, self._ready = 0, False

    @property
    def observations(self) -> Floats32:
        """Scaled observations, float32 [B, 11]; see ``hhrl_envs.observation``."""
        return self._observations[:, 0].T

    @property
    def terms(self) -> Floats:
        """Signed reward terms, float64 [B, 8]; see ``hhrl_envs.rewards``."""
        first = int(at.TERMS) // at.LANES
        return np.stack([self._of_agent(field) for field in range(first, first + at.TERMS_SIZE)], axis=1)

    @property
    def rewards(self) -> Floats:
        """r^task, float64 [B]."""
        rewards: Floats = self._results[0, 0]
        return rewards

    @property
    def reward_option(self) -> Floats:
        """r^option if option k is the selected one, float64 [B, 2]."""
        return self._results[1:3, 0].T

    @property
    def reward_action(self) -> Floats:
        """r^action if option k is the selected one, float64 [B, 2]."""
        return self._results[3:5, 0].T

    @property
    def outcomes(self) -> Codes:
        """``Outcome`` codes, int8 [B]."""
        outcomes: Codes = self._results[5, 0].astype(np.int8)
        return outcomes

    @property
    def steps(self) -> Ints:
        """Steps done in the current episode, int64 [B]."""
        return self._of_row(at.STEPS).astype(np.int64)

    @property
    def feasible(self) -> Flags:
        """Whether any ego could succeed in the current episode, bool [B]."""
        feasible: Flags = self._of_row(at.FEASIBLE) != 0.0
        return feasible

    def reset(self, seeds: ArrayLike) -> None:
        """Put every row at the start of episode 0 of its seed; ``seeds`` are integers [B] in [0, 2^64)."""
        self._keys[SEED] = _as_keys(seeds, self.num_rows)
        self._keys[EPISODE] = np.uint64(2**64 - 1)  # the one before episode 0
        self._ready = True
        self.next_episode(np.ones(self.num_rows, np.bool_))

    def reset_done(self) -> None:
        """Put every row whose episode has ended at the start of the next episode of its seed."""
        self.next_episode(self.outcomes != Outcome.RUNNING)

    def next_episode(self, chosen: Flags) -> None:
        """Put the chosen rows, bool [B], at the start of the next episode of their seeds."""
        self._require_reset()
        if chosen.any():
            self._write_rows(at.STATUS, np.where(chosen, WAITING, BEGUN))
            self._begin()
            self._show()

    def step(self, actions: ArrayLike, *, autoreset: bool = False) -> None:
        """Advance every running row by one step; ``actions`` are level indices, integers [B].

        With ``autoreset`` the rows that had ended before begin their next episode instead, with reward 0.
        """
        self._require_reset()
        self._aim(actions)
        self._advance(autoreset)

    def vehicles(self, row: int) -> Floats:
        """Return position [m], speed [m/s], acceleration [m/s^2] of the vehicles of one row, float64 [V, 3].

        Slot 0 is the ego, slot k its k-th front vehicle; vehicles that the episode does not have are NaN. A position is
        that of the front bumper, 0 at the first stop-line and negative before it.
        """
        picked = self._vehicles_of(row)[:-1, :3].copy()
        picked[picked[:, 0] > 0.5 * at.FAR] = np.nan
        return picked

    def active_line(self, row: int) -> float:
        """Return the position of the ego's active stop-line in one row, in metres; ``layout.FAR`` if there is none."""
        return float(self._vehicles_of(row)[0, int(at.LINE) // at.LANES])

    def profiles(self, row: int) -> list[dict[str, float | str]]:
        """Return the behaviour profiles of the front vehicles of one row, nearest first."""
        present = self._vehicles_of(row)[1:-1]
        present = present[present[:, 0] < 0.5 * at.FAR, int(at.PROFILE) // at.LANES :]
        return [describe(profile, self.scenario.traffic.families) for profile in present]

    def key(self, row: int) -> tuple[int, int]:
        """Return (seed, episode) of one row."""
        return int(self._keys[SEED, row]), int(self._keys[EPISODE, row])

    def _advance(self, autoreset: bool = False) -> None:
        if autoreset and self._ended:
            self._each_slice(advance_rows, self._observations, self._results, True, False, self.num_rows)
            self._begin()
            self._show()
        else:
            self._show(moving=True)

    def _show(self, moving: bool = False) -> None:
        """Hand out fresh results, after a step if ``moving``."""
        self._observations = np.empty((observation.SIZE, self._agents, self.num_rows), np.float32)
        self._results = np.empty((at.RESULTS_SIZE, self._agents, self.num_rows))
        arguments = (self._observations, self._results, moving, True, self.num_rows)
        self._ended = self._each_slice(advance_rows, *arguments)
        if self._history.size:
            self._each_slice(blur_rows, self._observations, self._keys, self._history, self.num_rows)

    def _begin(self) -> None:
        for _ in range(MAX_ATTEMPTS):
            if not self._each_slice(begin_rows, self._keys, *self._tables, self.num_rows):
                return
            self._each_slice(decide_rows, self.num_rows)
        hint = "widen its gaps or set feasible_only=False"
        raise InputError(f"scenario {self.scenario.id!r} draws no feasible world; {hint}")

    def _each_slice(self, kernel: Callable[..., int | None], *arguments: object) -> int:
        if self._pool is None:
            return kernel(self._memory, self._constants, *arguments, *self._slices[0]) or 0
        parts = self._pool.map(lambda part: kernel(self._memory, self._constants, *arguments, *part), self._slices)
        return sum(part or 0 for part in parts)

    def _aim(self, actions: ArrayLike) -> None:
        given, levels = np.asarray(actions), self.scenario.num_actions
        if given.shape != (self.num_rows,) or given.dtype.kind not in "iu":
            raise InputError(f"actions are {given.dtype} {given.shape}; write integers of shape ({self.num_rows},)")
        chosen = np.ascontiguousarray(given, np.int64)[None]
        bad = aim(self._memory, self._constants, chosen, self._levels, self.num_rows)
        if bad >= 0:
            raise InputError(f"action {given[bad]} is not a level of {self.scenario.id!r}; write 0 to {levels - 1}")

    def _require_reset(self) -> None:
        if not self._ready:
            raise InputError("the simulator has no episode yet; call reset(seeds) first")

    def _blocks(self) -> Floats:
        blocks: Floats = self._memory.reshape(-(-self.num_rows // at.LANES), -1, at.LANES)
        return blocks

    def _vehicles_of(self, row: int) -> Floats:
        """Return the records of one row's vehicles, float64 [slot, field], a view."""
        block = self._blocks()[row // at.LANES, :, row % at.LANES]
        fields = int(at.VEHICLE) // at.LANES
        return block[: self._slots * fields].reshape(self._slots, fields)

    def _of_row(self, field: int) -> Floats:
        """Return one number of every row, float64 [B], fresh."""
        place = int(field) // at.LANES - int(at.ROW) // at.LANES
        return self._blocks()[:, place].ravel()[: self.num_rows].copy()

    def _of_agent(self, field: int) -> Floats:
        """Return one number of every ego as an agent, float64 [B], fresh."""
        place = self._slots * (int(at.VEHICLE) // at.LANES) + field
        return self._blocks()[:, place].ravel()[: self.num_rows].copy()

    def _write_rows(self, field: int, values: Floats) -> None:
        place = int(field) // at.LANES - int(at.ROW) // at.LANES
        padded = np.zeros((len(self._blocks()), at.LANES))
        padded.ravel()[: self.num_rows] = values
        self._blocks()[:, place] = padded


def _as_keys(seeds: ArrayLike, num_rows: int) -> Keys:
    values = np.asarray(seeds)
    if values.shape != (num_rows,) or values.dtype.kind not in "iu" or (values.dtype.kind == "i" and values.min() < 0):
        raise InputError(f"seeds must be {num_rows} integers in [0, 2^64); got {values.dtype} {values.shape}")
    return values.astype(np.uint64)
