"""The overseer: looks at the board while units run, shows what stands there, and finds the units that have stalled."""

import time
from collections.abc import Callable, Iterable, Sequence

from hhrl_bench.board import Board, UnitStatus
from hhrl_bench.errors import RecordError

INTERVAL = 0.5
COST_SHARE = 20
"""The board is looked at again when this many times the time that looking took last has gone by."""

Show = Callable[[Sequence[UnitStatus]], None]
"""What hears how far the running units are."""


class Overseer:
    """Looks at ``board``; a unit whose file says the same for ``patience`` seconds, if any, has stalled.

    Only this process's clock counts, whatever the clocks of the nodes say.
    """

    def __init__(self, board: Board, show: Show, patience: float | None = None) -> None:
        self._board, self._show, self._patience = board, show, patience
        self._since: dict[str, tuple[UnitStatus, float]] = {}
        self._due = 0.0

    def begin_again(self, unit: str) -> None:
        """Return nothing; what the board says of an earlier attempt at the unit counts no more."""
        self._board.forget(unit)
        self._since.pop(unit, None)

    def look(self, running: Iterable[str]) -> list[str]:
        """Return the units that have stalled, and show how far all are; none, if it was done just before."""
        started = time.perf_counter()
        if started < self._due:
            return []
        before, self._since = self._since, {}
        for unit in running:
            status = self._read(unit)
            if status is not None and status.state == "running":
                said, since = before.get(unit, (None, started))
                self._since[unit] = (status, since if said == status else started)
        self._show([status for status, _ in self._since.values()])
        ended = time.perf_counter()
        self._due = ended + max(INTERVAL, COST_SHARE * (ended - started))
        return [unit for unit, (_, since) in self._since.items() if self._is_stalled(started - since)]

    def _is_stalled(self, seconds: float) -> bool:
        return self._patience is not None and seconds > self._patience

    def _read(self, unit: str) -> UnitStatus | None:
        try:
            return self._board.unit(unit)
        except RecordError:
            return None
