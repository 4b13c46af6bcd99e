"""What it costs to hand out units: two workers next to one, a unit's dispatch, and a driver of a thousand workers."""

import heapq
import resource
import time
from collections.abc import Sequence
from concurrent.futures import Future
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

from benchmarks.systems import Report
from hhrl_bench.cli.live_view import StudyView
from hhrl_bench.evaluation.records import TimedResult
from hhrl_bench.evaluation.results import Update, evaluate_agent, silent
from hhrl_bench.evaluation.store import Store
from hhrl_bench.execution.pools import LocalPool, Pool
from hhrl_bench.execution.progress_folder import ProgressFolder, StudyStatus, UnitStatus
from hhrl_bench.execution.run import Overseer, run_units
from hhrl_bench.execution.unit import Done, Unit, unit_status
from hhrl_bench.suites.units import Training, seed_trainings
from hhrl_bench.tasks.tasks import get_task

TASK = get_task("stop-line-v0")
WORKERS, OFFERED = 1000, 220
AnyUnit = TypeVar("AnyUnit", bound=Unit)


@dataclass(frozen=True, slots=True)
class Known:
    """A unit whose outcome is known."""

    name: str
    outcome: TimedResult

    def check(self) -> None:
        """Return nothing."""

    def run(self, update: Update = silent) -> TimedResult:
        """Return the outcome."""
        return self.outcome


class SimulatedPool(Pool):
    """A thousand workers in the same process, each of which takes ``seconds`` a unit and writes its progress."""

    def __init__(self, progress: ProgressFolder, seconds: float) -> None:
        super().__init__(WORKERS, progress)
        self._progress, self._seconds = progress, seconds
        self._due: list[tuple[float, int, Known, Future[Done]]] = []
        self._begun = 0
        self.lags: list[float] = []

    def wait(self, seconds: float) -> list[Done]:
        """Return the units that are due."""
        until = time.monotonic() + seconds
        time.sleep(max(min(until, self._due[0][0]) - time.monotonic(), 0.0))
        now = time.monotonic()
        while self._due and self._due[0][0] <= now:
            due, _, unit, future = heapq.heappop(self._due)
            future.set_result(Done(unit, unit.outcome))
            self._progress.write(unit_status(future.result(), 0.0))
            self.lags.append(now - due)
        return super().wait(0.0)

    def close(self) -> None:
        """Do nothing."""

    def _submit(self, unit: Unit) -> Future[Done]:
        """Return a future; the first thousand begin one after the other, at the rate at which they will end."""
        assert isinstance(unit, Known)
        future: Future[Done] = Future()
        spread = self._seconds * self._begun / WORKERS if self._begun < WORKERS else 0.0
        heapq.heappush(self._due, (time.monotonic() + self._seconds + spread, self._begun, unit, future))
        self._begun += 1
        note = "validation success 50%"
        self._progress.write(UnitStatus(unit=unit.name, state="running", done=1, total=2, note=note))
        return future

    def _result(self, unit: Unit, future: Future[Done]) -> Done:
        return future.result()

    def _kill(self, future: Future[Done]) -> None:
        pass


def known(count: int) -> list[Known]:
    outcome = TimedResult(result=evaluate_agent("rule-2", TASK, 3), seconds=5.0)
    return [Known(f"unit {number}", outcome) for number in range(count)]


def test_two_workers_next_to_one(tmp_path: Path, report: Report) -> None:
    task = replace(TASK, env_steps=75_000)
    seconds = []
    for workers in (1, 2):
        folder = tmp_path / str(workers)
        units = seed_trainings([Training("ddqn", task, tuple(range(8)), 100, folder, Store(folder))])
        seconds.append(timed(units, LocalPool(workers)))
    said = [f"{one:.1f} s" for one in seconds]
    report("8 trainings, 2 workers", said[1], "1 worker", said[0], f"{seconds[0] / seconds[1]:.2f}", ">= 1.8")


def test_the_dispatch_of_a_unit(tmp_path: Path, report: Report) -> None:
    pool, units = LocalPool(2, ProgressFolder(tmp_path)), known(1002)
    timed(units[:2], pool, close=False)
    each = timed(units[2:], pool) / 1000
    report("dispatch of a unit", f"{1000 * each:.2f} ms", "a unit of 10 s", "", f"{each / 10:.5f}", "< 0.01")


def test_a_driver_of_a_thousand_workers(tmp_path: Path, report: Report) -> None:
    progress, units = ProgressFolder(tmp_path / "progress"), known(WORKERS + 60 * OFFERED)
    view = StudyView("simulated", len(units), say=lambda _: None)
    pool = SimulatedPool(progress, WORKERS / OFFERED)
    ended, kilobytes, used = [], [], time.process_time()
    with progress.opened(StudyStatus(study="s", executor="ray", started="", units=tuple(unit.name for unit in units))):
        for done in run_units(units, pool, Overseer(progress, view.show, patience=600.0)):
            view.ended(done)
            ended.append(time.monotonic())
            kilobytes.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
    wall, lag = ended[-1] - ended[0], sorted(pool.lags)[int(0.99 * len(pool.lags))]
    memory = [f"{kilobytes[number] // 1024} MiB" for number in (4000, -1)]
    report("units a second", f"{len(units) / wall:.0f}", f"{WORKERS:,} workers offer", f"{OFFERED}", "", ">= 200")
    report("driver's share of a core", f"{(time.process_time() - used) / wall:.0%}", "", "", "", "")
    report("99% of units are seen within", f"{lag:.2f} s", "", "", "", "")
    report("memory after 4,000 units", memory[0], f"after {len(units):,}", memory[1], "", "equal")


def timed(units: Sequence[AnyUnit], pool: LocalPool, *, close: bool = True) -> float:
    """Return the seconds that a pool takes for the units, its processes' beginning included."""
    started = time.perf_counter()
    try:
        assert all(done.outcome for done in run_units(units, pool))
    finally:
        if close:
            pool.close()
    return time.perf_counter() - started
