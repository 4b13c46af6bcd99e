"""Pools: processes that do units, wherever they run."""

from collections import deque
from collections.abc import Collection, Sequence
from typing import Protocol

from hhrl_bench.execution.progress_board import Board
from hhrl_bench.execution.unit import Done, Unit, attempt


class Pool(Protocol):
    """Processes that do units; those that it was given and that have not ended are ``running``."""

    @property
    def free(self) -> int:
        """How many units more it takes now."""

    @property
    def running(self) -> Collection[Unit]:
        """The units that it was given and has not returned."""

    def begin(self, unit: Unit) -> None:
        """Return nothing; take a unit."""

    def wait(self, seconds: float) -> Sequence[Done]:
        """Return the units that have ended: at once if there are some, else after at most these seconds."""

    def stop(self, unit: Unit, reason: str) -> None:
        """Return nothing; end the process that does the unit, which is then lost for this reason."""

    def close(self) -> None:
        """Return nothing; no process of the pool is left, whatever it was doing."""


class Here:
    """This process itself, which does one unit after the other and cannot be stopped from outside."""

    free = 1

    def __init__(self, board: Board | None = None) -> None:
        self._board = board
        self.running: deque[Unit] = deque()

    def begin(self, unit: Unit) -> None:
        """Return nothing; see :class:`Pool`."""
        self.running.append(unit)
        self.free = 0

    def wait(self, seconds: float) -> list[Done]:
        """Return the unit, done."""
        self.free = 1
        return [attempt(self.running.popleft(), self._board)]

    def stop(self, unit: Unit, reason: str) -> None:
        """Return nothing, and do nothing: a unit has ended before anybody could ask."""

    def close(self) -> None:
        """Return nothing; there is nothing to end."""
