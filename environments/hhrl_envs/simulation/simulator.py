"""The batch simulator: B independent rows of one scenario, stepped together.

A step is: signals switch -> traffic and agents drive, front to back -> outcomes -> reward terms -> observations ->
(auto-reset). Row i with seed s gives bit-identical trajectories whatever the batch size, the number of threads and
whoever else is in it.
"""

from collections.abc import Callable
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from hhrl_envs.arrays import Codes, Flags, Floats, Floats32, Ints, Keys
from hhrl_envs.errors import InputError, require_value
from hhrl_envs.scenario.profiles import PARAMETERS, STYLES, ProfileFamily
from hhrl_envs.scenario.registry import as_count, as_learned_fronts, as_scenario
from hhrl_envs.scenario.scenario import Scenario
from hhrl_envs.scenario.validation import is_integer
from hhrl_envs.simulation.constants import pack
from hhrl_envs.simulation.engine import layout as at
from hhrl_envs.simulation.engine.layout import (
    ACTION_RESULTS,
    BEGUN,
    EPISODE,
    OPTION_RESULTS,
    SEED,
    WAITING,
    count_fields,
)
from hhrl_envs.simulation.engine.memory import ArrayPool, Memory, StepArrays
from hhrl_envs.simulation.engine.thread_pool import Workers
from hhrl_envs.simulation.reset import decide_rows
from hhrl_envs.simulation.sensing import CHANNELS, blur_rows
from hhrl_envs.simulation.step import BACKWARDS, BEGIN, MOVE_AND_SHOW, SHOW, advance_rows, aim
from hhrl_envs.state import State, count, read, read_count
from hhrl_envs.sub_goals import RUNNING

MAX_ATTEMPTS = 1000
MOST_AHEAD = 10_000_000  # steps times vehicles that these attempts drive a row ahead in all
MAKE_FEASIBLE = "give it wider gaps, more start_distance, less start_speed, more friction or a longer horizon"
"""What to do with a scenario of which few worlds can be solved, or none."""

_SHARES = (0.5, 0.25, 0.125, 0.125)  # of a thread's rows: the pieces that it takes, the small ones last


class Results(NamedTuple):
    """What one agent gets from a step, for all B rows.

    Attributes:
        observations: scaled observations, float32 [B, SIZE]; see ``hhrl_envs.observation``.
        rewards: r^task, float64 [B].
        reward_option, reward_action: r^option and r^action if option k is the selected one, float64 [B, K] for K
            sub-goals.
        outcomes: ``Outcome`` codes, int8 [B].
        terms: signed reward terms, float64 [B, 4 + 2 K]; see ``hhrl_envs.simulation.rewards``.
    """

    observations: Floats32
    rewards: Floats
    reward_option: Floats
    reward_action: Floats
    outcomes: Codes
    terms: Floats


class Simulator:
    """A batch of ``num_rows`` independent episodes of one scenario, stepped by ``threads`` threads.

    The ego is agent 0; with ``learned_fronts`` the front vehicles nearest to it are agents 1, 2, ... The properties are
    the ego's results of the last ``reset``, ``next_episode``, ``reset_done`` or ``step``; ``of_agent`` gives those of
    any agent. Each of these hands out fresh arrays, so what you keep never changes. An agent whose episode has ended
    keeps its outcome and earns nothing until the row's next episode begins. ``ended`` counts those agents.
    """

    def __init__(self, scenario: Scenario | str, num_rows: int, threads: int = 1, learned_fronts: int = 0) -> None:
        scenario = as_scenario(scenario)
        learned_fronts = as_learned_fronts(learned_fronts, scenario)
        num_rows, threads = as_count(num_rows, "num_rows"), as_count(threads, "threads")
        self.scenario, self.num_rows, self.num_agents = scenario, num_rows, 1 + learned_fronts
        self._memory = Memory(num_rows, scenario.num_vehicles + 1, self.num_agents)
        self._numbers, self._constants = self._memory.numbers, pack(scenario, self.num_agents)
        self._targets = [self._memory.target(agent) for agent in range(self.num_agents)]
        self._shape = (num_rows,) if self.num_agents == 1 else (num_rows, self.num_agents)
        self._keys, self._levels = np.zeros((2, num_rows), np.uint64), np.array(scenario.vehicle.levels)
        self._pool = ArrayPool(self.num_agents, num_rows)
        self._history = np.zeros((scenario.sensor.delay + 1, len(CHANNELS), self.num_agents, num_rows))
        self._workers = Workers(threads - 1) if threads > 1 else None
        self._blocks, self._noisy = self._memory.blocks, not scenario.sensor.perfect
        self._slices = [(0, self._blocks)] if threads == 1 else _pieces(self._blocks, threads)
        self._special = True if learned_fronts or not scenario.plain else None
        self.ended, self._ready, self._direction = 0, False, 0

    @property
    def observations(self) -> Floats32:
        """Scaled observations, float32 [B, SIZE]; see ``hhrl_envs.observation``."""
        self._require_reset()
        return self.arrays.observations

    @property
    def terms(self) -> Floats:
        """Signed reward terms, float64 [B, 4 + 2 K]; see ``hhrl_envs.simulation.rewards``."""
        self._require_reset()
        return self._memory.of_agent(0, at.TERMS, at.TERMS_SIZE)

    @property
    def rewards(self) -> Floats:
        """r^task, float64 [B]."""
        self._require_reset()
        return self.arrays.rewards

    @property
    def reward_option(self) -> Floats:
        """r^option if option k is the selected one, float64 [B, K] for K sub-goals."""
        self._require_reset()
        return self.arrays.reward_option

    @property
    def reward_action(self) -> Floats:
        """r^action if option k is the selected one, float64 [B, K] for K sub-goals."""
        self._require_reset()
        return self.arrays.reward_action

    @property
    def outcomes(self) -> Codes:
        """``Outcome`` codes, int8 [B]."""
        self._require_reset()
        return self.arrays.outcomes

    @property
    def agent_outcomes(self) -> Codes:
        """``Outcome`` codes of all agents, int8 [B, A]."""
        self._require_reset()
        outcomes: Codes = self.arrays.all_codes[0].T
        return outcomes

    @property
    def steps(self) -> Ints:
        """Steps done in the current episode, int64 [B]."""
        self._require_reset()
        return self._memory.of_row(at.STEPS).astype(np.int64)

    @property
    def feasible(self) -> Flags:
        """Whether any ego could succeed in the current episode, bool [B].

        With learned front vehicles the verdict holds once the ego's episode has ended.
        """
        self._require_reset()
        feasible: Flags = self._memory.of_row(at.FEASIBLE) != 0.0
        return feasible

    @property
    def friction(self) -> Floats:
        """The friction of the road in the current episode, float64 [B]; no observation tells it."""
        self._require_reset()
        return self._memory.of_agent(0, at.ROAD_FRICTION, 1)[:, 0]

    def of_agent(self, agent: int) -> Results:
        """Return the results of one agent: 0 is the ego, k the learned front vehicle in slot k."""
        self._require_reset()
        _require_index("agent", agent, self.num_agents)
        arrays = self.arrays
        results, outcomes = arrays.all_results[:, agent], arrays.all_codes[0, agent]
        terms = self._memory.of_agent(agent, at.TERMS, at.TERMS_SIZE)
        option, action = results[OPTION_RESULTS].T, results[ACTION_RESULTS].T
        return Results(arrays.all_observations[:, agent].T, results[0], option, action, outcomes, terms)

    def ahead(self, agent: int) -> tuple[Floats, Floats]:
        """Return the free road [m] to the vehicle ahead of an agent, and how fast it closes [m/s], float64 [B] each.

        They are the truth, whatever the sensors see; without a vehicle the road is hundreds of kilometres long.
        """
        self._require_reset()
        _require_index("agent", agent, self.num_agents)
        own, front = (self._memory.of_agent(slot, at.POSITION, 2).T for slot in (agent, agent + 1))
        return front[0] - self.scenario.vehicle.length - own[0], own[1] - front[1]

    def motion(self, slot: int) -> Floats:
        """Return position [m], speed [m/s], acceleration [m/s^2] and jerk [m/s^3] of a slot's vehicle, float64 [B, 4].

        Slot 0 is the ego, slot k its k-th front vehicle. A vehicle that is not there is hundreds of kilometres away.
        """
        self._require_reset()
        _require_index("slot", slot, self.scenario.num_vehicles + 1)
        return self._memory.of_agent(slot, at.POSITION, 4)

    @property
    def lines(self) -> Floats:
        """The positions of the egos' active stop-lines [m], float64 [B]; ``layout.FAR`` where there is none."""
        self._require_reset()
        return self._memory.of_agent(0, at.LINE, 1)[:, 0]

    def reset(self, seeds: ArrayLike, chosen: Flags | None = None) -> None:
        """Put rows at the start of episode 0 of their seeds.

        ``seeds`` are integers [B] in [0, 2^64); of them those of the ``chosen`` rows count, bool [B], or all.
        """
        keys, first = _as_keys(seeds, self.num_rows), np.uint64(2**64 - 1)  # the one before episode 0
        if chosen is None:
            self._keys[SEED], self._keys[EPISODE], self._ready = keys, first, True
        else:
            self._require_reset()
            _require_mask(chosen, self.num_rows)
            self._keys[:, chosen] = np.stack([keys, np.full_like(keys, first)])[:, chosen]
        self.next_episode(chosen)

    def reset_done(self) -> None:
        """Put every row whose episode has ended, for all of its agents, at the start of the next one of its seed."""
        self._require_reset()
        if self.ended:
            self.next_episode((self.arrays.all_codes[0] != RUNNING).all(axis=0))

    def next_episode(self, chosen: Flags | None = None) -> None:
        """Put the chosen rows, bool [B], at the start of the next episode of their seeds; None chooses all."""
        self._require_reset()
        if chosen is None:
            self._memory.write_row(at.STATUS, WAITING)
        else:
            _require_mask(chosen, self.num_rows)
            if not chosen.any():
                return
            self._memory.write_row(at.STATUS, np.where(chosen, WAITING, BEGUN))
        self._show(BEGIN | SHOW)

    def step(self, actions: ArrayLike, *, autoreset: bool = False) -> None:
        """Advance every running row by one step.

        ``actions`` are [B], or [B, A] with learned front vehicles: level indices if they are integers, target
        accelerations in m/s^2 within the vehicle's levels if they are floats. With ``autoreset`` the rows that had
        ended before begin their next episode instead, with reward 0.
        """
        self._require_reset()
        self._aim(np.asarray(actions))
        self._show(MOVE_AND_SHOW | BEGIN if autoreset and self.ended else MOVE_AND_SHOW)

    def step_row(self, accelerations: dict[int, float]) -> None:
        """Advance a simulator of one row by one step; ``accelerations`` are the targets of its agents, not checked.

        It is the quick way for a view of one row: the last results are overwritten, so copy what you keep.
        """
        for agent, acceleration in accelerations.items():
            self._numbers[self._targets[agent]] = acceleration
        self._run(MOVE_AND_SHOW)

    def vehicles(self, row: int) -> Floats:
        """Return position [m], speed [m/s], acceleration [m/s^2] of the vehicles of one row, float64 [V, 3].

        Slot 0 is the ego, slot k its k-th front vehicle; vehicles that the episode does not have are NaN. A position is
        that of the front bumper, 0 at the first stop-line and negative before it.
        """
        picked = self._vehicles(row)[:-1, :3].copy()
        picked[picked[:, 0] > 0.5 * at.FAR] = np.nan
        return picked

    def profiles(self, row: int) -> list[dict[str, float | str]]:
        """Return the behaviour profiles of the front vehicles of one row, nearest first."""
        fronts, first = self._vehicles(row)[1:-1].tolist(), count_fields(at.PROFILE)
        families = self.scenario.traffic.families
        return [describe(front[first:], families) for front in fronts if front[0] < 0.5 * at.FAR]

    def key(self, row: int) -> tuple[int, int]:
        """Return (seed, episode) of one row."""
        self._require_reset()
        _require_index("row", row, self.num_rows)
        return int(self._keys[SEED, row]), int(self._keys[EPISODE, row])

    def state(self) -> State:
        """Return all that the next steps depend on; see ``restore``."""
        self._require_reset()
        own = self._state_arrays(self.arrays)
        return {**{name: array.copy() for name, array in own.items()}, "ended": count(self.ended)}

    def restore(self, state: State) -> None:
        """Go on, bit for bit, where a simulator of the same scenario and size has been at ``state``.

        Raises:
            InputError: if it is the state of something else.
        """
        arrays = self._pool.take()
        for name, array in self._state_arrays(arrays).items():
            array[...] = read(state, name, array)
        self.arrays = arrays
        self.ended, self._ready = read_count(state, "ended"), True

    def _state_arrays(self, arrays: StepArrays) -> State:
        own: State = {"numbers": self._numbers, "keys": self._keys, "history": self._history}
        own |= {"observations": arrays.all_observations, "results": arrays.all_results, "codes": arrays.all_codes}
        return own

    def _vehicles(self, row: int) -> Floats:
        self._require_reset()
        _require_index("row", row, self.num_rows)
        return self._memory.vehicles(row)

    def _show(self, parts: int) -> None:
        """Do these parts of a step and hand out fresh ``arrays``."""
        self.arrays = self._pool.take()
        self._direction ^= BACKWARDS
        self._run(parts | self._direction)
        if self.ended < 0:
            self._decide()

    def _decide(self) -> None:
        """Decide the rows whose worlds are OPEN, draw infeasible ones anew if only feasible ones are wanted."""
        attempts, left = 0, MOST_AHEAD
        while attempts < MAX_ATTEMPTS and left > 0:
            attempts += 1
            left -= max(self._each_slice(decide_rows, self._special, self.num_rows)) * self.scenario.num_vehicles
            self._run(BEGIN | SHOW)
            if self.ended >= 0:
                return
        hint = f"{MAKE_FEASIBLE}, or set feasible_only=False"
        raise InputError(f"scenario {self.scenario.id!r} draws no feasible world; {hint}")

    def _run(self, parts: int) -> None:
        """Do these parts of a step; see ``step``."""
        numbers, c, keys, special = self._numbers, self._constants, self._keys, self._special
        arrays = self.arrays
        observations, results, codes = arrays.all_observations, arrays.all_results, arrays.all_codes
        if self._workers is None:
            ended = advance_rows(numbers, c, keys, observations, results, codes, parts, special, 0, self._blocks)
        else:
            counts = self._each_slice(advance_rows, keys, observations, results, codes, parts, special)
            ended = min(counts) if min(counts) < 0 else sum(counts)
        self.ended = ended
        if self._noisy and parts & SHOW:
            self._each_slice(blur_rows, observations, keys, self._history, self.num_rows)

    def _each_slice(self, kernel: Callable[..., Any], *arguments: object) -> list[Any]:
        """Return what a kernel returns for every slice of the rows, each of them run by a thread of its own."""
        calls = [(self._numbers, self._constants, *arguments, *part) for part in self._slices]
        return [kernel(*calls[0])] if self._workers is None else self._workers.run(kernel, calls)

    def _aim(self, given: Floats | Ints) -> None:
        kind = given.dtype.kind
        if given.shape != self._shape or kind not in "iuf":
            wanted = f"integers (levels) or floats (m/s^2) of shape {self._shape}"
            raise InputError(f"actions are {given.dtype} {given.shape}; write {wanted}")
        if kind == "f":
            self._aim_at(given.astype(np.float64))
            return
        chosen = np.asarray(given.T, np.int64).ravel()
        if not aim(self._numbers, self._constants, chosen, self._levels):
            levels = f"write 0 to {self.scenario.num_actions - 1}"
            agent, row = divmod(int(np.flatnonzero((chosen < 0) | (chosen >= len(self._levels)))[0]), self.num_rows)
            action = given[row] if self.num_agents == 1 else given[row, agent]
            raise InputError(f"action {action} of row {row} is not a level of {self.scenario.id!r}; {levels}")

    def _aim_at(self, accelerations: Floats) -> None:
        low, high = self._levels[0], self._levels[-1]
        outside = accelerations[~((accelerations >= low) & (accelerations <= high))]
        if outside.size:
            raise InputError(f"target acceleration {outside[0]} is out of range; write {low} to {high} m/s^2")
        self._memory.write_targets(accelerations.reshape(self.num_rows, self.num_agents))

    def _require_reset(self) -> None:
        if not self._ready:
            raise InputError("no episode has begun yet; call reset first")


def _pieces(blocks: int, threads: int) -> list[tuple[int, int]]:
    """Return the pieces of the blocks, low and high each: large at both ends, small where the threads meet.

    The caller takes from the first on, the others from the last on; see ``engine.thread_pool``.
    """
    caller, others = [*_SHARES], [share for share in reversed(_SHARES) for _ in range(threads - 1)]
    edges = np.rint(np.cumsum([0.0, *caller, *others]) * (blocks / threads)).astype(int).tolist()
    return [(low, high) for low, high in pairwise(edges) if low < high]


def _require_index(name: str, value: Any, count: int) -> None:
    allowed = f"an integer from 0 to {count - 1}" if count > 1 else "0"
    require_value(is_integer(value) and 0 <= value < count, name, repr(value), allowed)


def _require_mask(chosen: Any, rows: int) -> None:
    known = isinstance(chosen, np.ndarray) and chosen.dtype == np.bool_ and chosen.shape == (rows,)
    require_value(known, "chosen", chosen, f"an array of {rows} truth values")


def _as_keys(seeds: ArrayLike, num_rows: int) -> Keys:
    values = np.asarray(seeds)
    if values.shape != (num_rows,) or values.dtype.kind not in "iu":
        raise InputError(f"seeds are {values.dtype} {values.shape}; write {num_rows} integers from 0 to 2^64 - 1")
    if values.dtype.kind == "i" and values.min() < 0:
        raise InputError(f"a seed is {values.min()}; write integers from 0 to 2^64 - 1")
    return values.astype(np.uint64)


def describe(profile: list[float], families: tuple[ProfileFamily, ...]) -> dict[str, float | str]:
    """Return a profile, the fields from PROFILE on, as a readable dict: family, stop style, every parameter."""
    style, family = (int(number) for number in profile[len(PARAMETERS) : len(PARAMETERS) + 2])
    return {"family": families[family].name, "style": STYLES[style], **dict(zip(PARAMETERS, profile, strict=False))}
