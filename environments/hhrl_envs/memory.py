"""The memory of a batch as Python sees it; see ``layout`` for where its numbers lie."""

import numpy as np

from hhrl_envs import layout as at
from hhrl_envs.compiled import Floats


def _records(size: int) -> int:
    """Return the number of fields of a record, or the place of a field in it."""
    return int(size) // at.STRIDE


class Memory:
    """The numbers of ``rows`` rows with so many vehicle slots and agents; at first no row has an episode.

    Attributes:
        numbers: float64 [...], all of it, as the kernels take it.
        blocks: how many blocks of rows it has.
    """

    def __init__(self, rows: int, slots: int, agents: int) -> None:
        self.rows, self.slots, self.agents = rows, slots, agents
        self.blocks = -(-rows // at.LANES)
        fields = slots * _records(at.VEHICLE) + agents * _records(at.AGENT) + _records(at.ROW)
        self.numbers: Floats = np.zeros(self.blocks * fields * at.STRIDE)

    @property
    def fields(self) -> Floats:
        """The numbers as float64 [block, field, lane], a view."""
        return self.numbers.reshape(self.blocks, -1, at.STRIDE)[:, :, : at.LANES]

    def of_row(self, field: int) -> Floats:
        """Return one number of every row, float64 [rows], fresh."""
        return self.fields[:, _records(field) - _records(at.ROW)].ravel()[: self.rows].copy()

    def write_row(self, field: int, values: Floats) -> None:
        """Write one number of every row, float64 [rows]."""
        self._write(_records(field) - _records(at.ROW), values)

    def of_agent(self, agent: int, first: int, count: int) -> Floats:
        """Return ``count`` numbers of one agent from field ``first`` on, float64 [rows, count], fresh."""
        place = self._agent(agent) + _records(first)
        picked = self.fields[:, place : place + count].swapaxes(1, 2).reshape(-1, count)
        return picked[: self.rows].copy()

    def write_targets(self, accelerations: Floats) -> None:
        """Write the agents' target accelerations, float64 [rows, agents]."""
        for agent in range(self.agents):
            self._write(self._agent(agent) + _records(at.TARGET), accelerations[:, agent])

    def target(self, agent: int) -> int:
        """Return where in ``numbers`` the target acceleration of an agent in row 0 lies."""
        return (self._agent(agent) + _records(at.TARGET)) * at.STRIDE

    def vehicles(self, row: int) -> Floats:
        """Return the records of one row's vehicles, float64 [slots, field], a view."""
        fields = _records(at.VEHICLE)
        block = self.fields[row // at.LANES, : self.slots * fields, row % at.LANES]
        return block.reshape(self.slots, fields)

    def _agent(self, agent: int) -> int:
        return self.slots * _records(at.VEHICLE) + agent * _records(at.AGENT)

    def _write(self, place: int, values: Floats) -> None:
        padded = np.zeros(self.blocks * at.LANES)
        padded[: self.rows] = values
        self.fields[:, place] = padded.reshape(self.blocks, at.LANES)
