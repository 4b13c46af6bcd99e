"""Doing the units of a study. Which processes did them is provenance, never a difference in numbers."""

import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from typing import Final, Literal

from hhrl_bench.errors import RecordError
from hhrl_bench.evaluation.results import silent
from hhrl_bench.execution.pools import LocalPool, Pool, RayPool, SerialPool
from hhrl_bench.execution.progress_folder import ProgressFolder, UnitStatus
from hhrl_bench.execution.unit import Done, Stages, Unit, unit_status
from hhrl_envs import SCENARIOS, Simulator

ATTEMPTS = 3
"""How often a unit is begun whose process is lost or stalls."""

_TICK = 0.2
"""Seconds after which progress may be read, though no unit has ended."""

_READ_INTERVAL = 0.5
"""Least seconds between two readings of the progress."""

_READ_SHARE = 20
"""Progress is read again when this many times the time that reading took last has gone by."""


@dataclass(frozen=True, slots=True)
class Execution:
    """Who does the units.

    Attributes:
        executor: processes of this machine, or a Ray cluster.
        workers: how many processes of this machine; 1: this one itself, unless units have to be timed.
        address: of the cluster; see :class:`hhrl_bench.execution.pools.RayPool`.
        patience: seconds without a word of a unit after which its process is killed; None: any.
    """

    executor: Literal["local", "ray"] = "local"
    workers: int = 1
    address: str | None = None
    patience: float | None = None

    @contextmanager
    def pool(self, folder: ProgressFolder | None = None) -> Iterator[Pool]:
        """Return a context with a pool, of which no process is left after it."""
        with closing(self._pool(folder)) as pool:
            yield pool

    def _pool(self, folder: ProgressFolder | None) -> Pool:
        if self.executor == "ray":
            return RayPool(self.address, folder)
        if self.workers == 1 and self.patience is None:
            return SerialPool(folder)
        Simulator(next(iter(SCENARIOS)), 1).reset([0])  # compiled once, so that the workers find it in the cache
        return LocalPool(self.workers, folder)


IN_THIS_PROCESS: Final = Execution()

Show = Callable[[Sequence[UnitStatus]], None]
"""What is called with how far the running units are."""


class Overseer:
    """Reads the progress of running units; one that says the same for ``patience`` seconds, if any, has stalled.

    Only this process's clock counts, whatever the clocks of the nodes say.
    """

    def __init__(self, folder: ProgressFolder, show: Show, patience: float | None = None) -> None:
        self._folder, self._show, self._patience = folder, show, patience
        self._since: dict[str, tuple[UnitStatus, float]] = {}
        self._due = 0.0

    def forget(self, unit: str) -> None:
        """Drop what an earlier attempt at a unit has said."""
        self._folder.forget(unit)
        self._since.pop(unit, None)

    def stalled(self, running: Iterable[str]) -> list[str]:
        """Show how far the running units are and return those that have stalled; nothing, if that was just done."""
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
        self._due = ended + max(_READ_INTERVAL, _READ_SHARE * (ended - started))
        return [unit for unit, (_, since) in self._since.items() if self._is_too_long(started - since)]

    def _is_too_long(self, seconds: float) -> bool:
        return self._patience is not None and seconds > self._patience

    def _read(self, unit: str) -> UnitStatus | None:
        try:
            return self._folder.unit(unit)
        except RecordError:
            return None


def run_units(units: Sequence[Unit], pool: Pool, overseer: Overseer | None = None) -> Iterator[Done]:
    """Yield the units as the pool does them.

    A unit that fails does not keep the others from being done. One whose process is lost, or that stalls and is
    stopped, is begun ``ATTEMPTS`` times at most, and goes on where it was if it trains.
    """
    waiting, begun = deque(units), Counter[str]()
    while waiting or pool.running:
        while waiting and pool.free > 0:
            unit = waiting.popleft()
            begun[unit.name] += 1
            if overseer and begun[unit.name] > 1:
                overseer.forget(unit.name)
            pool.begin(unit)
        for done in pool.wait(_TICK):
            if done.lost and begun[done.unit.name] < ATTEMPTS:
                waiting.append(done.unit)
            else:
                yield _given_up(done) if done.lost else done
        if overseer:
            _stop_stalled(pool, overseer)


def _given_up(done: Done) -> Done:
    return done._replace(failure=f"given up after {ATTEMPTS} attempts: {done.failure}")


def _stop_stalled(pool: Pool, overseer: Overseer) -> None:
    stalled = set(overseer.stalled([unit.name for unit in pool.running]))
    for unit in [unit for unit in pool.running if unit.name in stalled]:
        pool.stop(unit, "it said nothing for longer than --unit-timeout allows")


def run_stages(
    stages: Stages, execution: Execution, folder: ProgressFolder | None = None, show: Show = silent
) -> Iterator[Done]:
    """Yield every unit as it is done; after a stage in which one has failed the next ones are not begun.

    What becomes of the units is written to the progress folder, if any; ``show`` is called with how far they are.

    Raises:
        InputError: before anything is done, if it is plain that a unit cannot be.
    """
    for stage in stages:
        for unit in stage:
            unit.check()
    with execution.pool(folder) as pool:
        overseer = Overseer(folder, show, execution.patience) if folder else None
        for stage in stages:
            failed = False
            for done in run_units(stage, pool, overseer):
                failed |= done.outcome is None
                if folder and done.lost:
                    folder.write(unit_status(done, 0.0))
                yield done
            if failed:
                return
