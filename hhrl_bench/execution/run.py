"""Executors: who does the units of a suite. Which one did is provenance, never a difference in numbers."""

import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from typing import Final, Literal

from hhrl_bench.errors import RecordError
from hhrl_bench.execution.local_pool import LocalPool
from hhrl_bench.execution.pool import Here, Pool
from hhrl_bench.execution.progress_board import Board, UnitStatus
from hhrl_bench.execution.ray_pool import RayPool
from hhrl_bench.execution.unit import Done, Stages, Unit, unit_status
from hhrl_bench.progress import silent
from hhrl_envs import SCENARIOS, Simulator

ATTEMPTS = 3
"""How often a unit is begun whose worker is lost or stalls."""

TICK = 0.2
"""Seconds after which the overseer may look at the board, though no unit has ended."""


@dataclass(frozen=True, slots=True)
class Execution:
    """Who does the units.

    Attributes:
        executor: processes of this machine, or a Ray cluster.
        workers: how many processes of this machine; 1: this one itself, unless units have to be timed.
        address: of the cluster; see :class:`hhrl_bench.execution.ray_pool.RayPool`.
        patience: seconds without a word of a unit after which its worker is ended; None: any.
    """

    executor: Literal["local", "ray"] = "local"
    workers: int = 1
    address: str | None = None
    patience: float | None = None

    @contextmanager
    def pool(self, board: Board | None = None) -> Iterator[Pool]:
        """Return a context with a pool, of which nothing is left after it."""
        with closing(self._pool(board)) as pool:
            yield pool

    def _pool(self, board: Board | None) -> Pool:
        if self.executor == "ray":
            return RayPool(self.address, board)
        if self.workers == 1 and self.patience is None:
            return Here(board)
        Simulator(next(iter(SCENARIOS)), 1).reset([0])  # compiled once, so that the workers find it in the cache
        return LocalPool(self.workers, board)


HERE: Final = Execution()

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


def run_units(units: Sequence[Unit], pool: Pool, overseer: Overseer | None = None) -> Iterator[Done]:
    """Return the units as the pool has done them.

    A unit that fails does not keep the others from being done; one whose worker is lost, or has stalled and is ended,
    is begun ``ATTEMPTS`` times at most, and goes on where it was if it trains.
    """
    waiting, begun = deque(units), Counter[str]()
    while waiting or pool.running:
        while waiting and pool.free > 0:
            unit = waiting.popleft()
            begun[unit.name] += 1
            if overseer and begun[unit.name] > 1:
                overseer.begin_again(unit.name)
            pool.begin(unit)
        for done in pool.wait(TICK):
            if done.lost and begun[done.unit.name] < ATTEMPTS:
                waiting.append(done.unit)
            else:
                yield _given_up(done) if done.lost else done
        if overseer:
            _oversee(pool, overseer)


def _given_up(done: Done) -> Done:
    return done._replace(failure=f"given up after {ATTEMPTS} attempts: {done.failure}")


def _oversee(pool: Pool, overseer: Overseer) -> None:
    """End the workers of the units that have stalled."""
    stalled = set(overseer.look([unit.name for unit in pool.running]))
    for unit in [unit for unit in pool.running if unit.name in stalled]:
        pool.stop(unit, "it said nothing for longer than --unit-timeout allows")


INTERVAL = 0.5
COST_SHARE = 20
"""The board is looked at again when this many times the time that looking took last has gone by."""


def run_stages(stages: Stages, execution: Execution, board: Board | None = None, show: Show = silent) -> Iterator[Done]:
    """Return every unit as it is done; after a stage in which one has failed the next ones are not begun.

    What becomes of the units stands on the board, if any; ``show`` hears how far the running ones are.

    Raises:
        InputError: before anything is done, if it is plain that a unit cannot be.
    """
    for stage in stages:
        for unit in stage:
            unit.check()
    with execution.pool(board) as pool:
        overseer = Overseer(board, show, execution.patience) if board else None
        for stage in stages:
            failed = False
            for done in run_units(stage, pool, overseer):
                failed |= done.outcome is None
                if board and done.lost:
                    board.write(unit_status(done, 0.0))
                yield done
            if failed:
                return
