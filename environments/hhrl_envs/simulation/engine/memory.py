"""The memory of a batch as Python sees it; see ``layout`` for where its numbers lie."""

from sys import getrefcount
from typing import Any, NamedTuple

import numpy as np

from hhrl_envs import observation
from hhrl_envs.arrays import Codes, Flags, Floats, Floats32
from hhrl_envs.simulation.engine import layout as at
from hhrl_envs.simulation.engine.layout import ACTION_RESULTS, OPTION_RESULTS, count_fields


class Memory:
    """The numbers of ``rows`` rows with so many vehicle slots and agents; at first no row has an episode.

    Attributes:
        numbers: float64 [...], all of it, as the kernels take it.
        blocks: how many blocks of rows it has.
    """

    def __init__(self, rows: int, slots: int, agents: int) -> None:
        self.rows, self.slots, self.agents = rows, slots, agents
        self.blocks = -(-rows // at.LANES)
        fields = count_fields(at.ROW) + slots * count_fields(at.VEHICLE)
        self.numbers: Floats = _aligned_zeros(self.blocks * fields * at.STRIDE)

    @property
    def fields(self) -> Floats:
        """The numbers as float64 [block, field, lane], a view."""
        return self.numbers.reshape(self.blocks, -1, at.STRIDE)[:, :, : at.LANES]

    def of_row(self, field: int) -> Floats:
        """Return one number of every row, float64 [rows], fresh."""
        return self.fields[:, count_fields(field)].ravel()[: self.rows].copy()

    def write_row(self, field: int, values: Floats | float) -> None:
        """Write one number of every row, float64 [rows] or the same for all."""
        place = count_fields(field)
        if isinstance(values, float):
            self.fields[:, place] = values
        else:
            self._write(place, values)

    def of_agent(self, agent: int, first: int, count: int) -> Floats:
        """Return ``count`` numbers of one agent from field ``first`` on, float64 [rows, count], fresh."""
        place = _vehicle(agent) + count_fields(first)
        picked = self.fields[:, place : place + count].swapaxes(1, 2).reshape(-1, count)
        return picked[: self.rows].copy()

    def write_targets(self, accelerations: Floats) -> None:
        """Write the agents' target accelerations, float64 [rows, agents]."""
        for agent in range(self.agents):
            self._write(_vehicle(agent) + count_fields(at.TARGET), accelerations[:, agent])

    def target(self, agent: int) -> int:
        """Return where in ``numbers`` the target acceleration of an agent in row 0 lies."""
        return (_vehicle(agent) + count_fields(at.TARGET)) * at.STRIDE

    def vehicles(self, row: int) -> Floats:
        """Return the records of one row's vehicles, float64 [slots, field], a view."""
        block = self.fields[row // at.LANES, _vehicle(0) :, row % at.LANES]
        return block.reshape(self.slots, -1)

    def _write(self, place: int, values: Floats) -> None:
        whole, rest = divmod(self.rows, at.LANES)
        numbers, end = self.fields[:, place], whole * at.LANES
        numbers[:whole] = values[:end].reshape(whole, at.LANES)
        if rest:
            numbers[whole, :rest] = values[end:]


def _aligned_zeros(size: int) -> Floats:
    """Return zeros, float64 [size], aligned to a cache line: a vector that lies in two costs twice."""
    numbers: Floats = np.zeros(size + 7)
    first = -(numbers.ctypes.data // 8) % 8
    return numbers[first : first + size]


def _vehicle(slot: int) -> int:
    """Return how many fields of a block lie before the record of a vehicle."""
    return count_fields(at.ROW) + slot * count_fields(at.VEHICLE)


_MOST = 3  # sets of arrays kept: what a step hands out, what it replaces, and one in use elsewhere


class StepArrays(NamedTuple):
    """What the agents of all B rows get from a step; keep its arrays, not this tuple of them.

    Attributes:
        all_observations, all_results, all_codes: what the kernel fills, float32 [SIZE, A, B], float64 [RESULTS_SIZE, A,
            B] and int8 [3, A, B]; see ``step.advance_rows``. All else is views of the ego's part of them.
        observations: scaled observations, float32 [B, SIZE]; see ``hhrl_envs.observation``.
        rewards: r^task, float64 [B].
        reward_option, reward_action: r^option and r^action if option k is the selected one, float64 [B, K] for K
            sub-goals.
        outcomes: ``Outcome`` codes, int8 [B].
        terminations, truncations: whether the step ended the episode, and how, bool [B].
    """

    all_observations: Floats32
    all_results: Floats
    all_codes: Codes
    observations: Floats32
    rewards: Floats
    reward_option: Floats
    reward_action: Floats
    outcomes: Codes
    terminations: Flags
    truncations: Flags

    def __reduce__(self) -> Any:
        """Return how to copy or unpickle it, so that its views are views again."""
        return arrays_of, self[:3]


class ArrayPool:
    """Hands out arrays for ``agents`` agents in ``rows`` rows, none of them while somebody holds one."""

    def __init__(self, agents: int, rows: int) -> None:
        self._shape = agents, rows
        self._kept: list[tuple[StepArrays, int]] = []

    def take(self) -> StepArrays:
        """Return arrays with arbitrary contents that nobody else has."""
        for place, (arrays, free) in enumerate(self._kept):
            if sum(map(getrefcount, arrays)) == free:
                self._kept.insert(1, self._kept.pop(place))  # two go to and fro: the last but one comes first
                return arrays
        observations = np.empty((observation.SIZE, *self._shape), np.float32)
        results, codes = np.empty((at.RESULTS_SIZE, *self._shape)), np.empty((3, *self._shape), np.int8)
        fresh = arrays_of(observations, results, codes)
        del observations, results, codes
        self._kept = [*self._kept[: _MOST - 1], (fresh, sum(map(getrefcount, fresh)))]
        return fresh


def arrays_of(observations: Floats32, results: Floats, codes: Codes) -> StepArrays:
    """Return what the kernel fills, with its views."""
    ego, flags = results[:, 0], codes[:, 0].view(np.bool_)
    option, action = ego[OPTION_RESULTS].T, ego[ACTION_RESULTS].T
    views = (observations[:, 0].T, ego[0], option, action, codes[0, 0], flags[1], flags[2])
    return StepArrays(observations, results, codes, *views)
