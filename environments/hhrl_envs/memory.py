"""The memory of a batch as Python sees it; see ``layout`` for where its numbers lie."""

import numpy as np

from hhrl_envs import layout as at
from hhrl_envs.compiled import Floats


def count_fields(offset: int) -> int:
    """Return how many fields lie before an offset in a record: a field's number, or a record's size."""
    return int(offset) // at.STRIDE


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
    """Return zeros, float64 [size], from the beginning of a cache line on: a vector that lies in two costs twice."""
    numbers: Floats = np.zeros(size + 7)
    first = -(numbers.ctypes.data // 8) % 8
    return numbers[first : first + size]


def _vehicle(slot: int) -> int:
    """Return how many fields of a block lie before the record of a vehicle."""
    return count_fields(at.ROW) + slot * count_fields(at.VEHICLE)
