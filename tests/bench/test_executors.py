"""Executors: every unit done once, failures kept apart, a unit whose worker dies begun again."""

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from hhrl_bench.executors import ATTEMPTS, run_units
from hhrl_bench.records import TimedResult
from hhrl_bench.results import evaluate_agent
from hhrl_bench.tasks import get_task
from hhrl_bench.units import Evaluation, Unit
from hhrl_envs import InputError

TASK = get_task("stop-line-v0")


@dataclass(frozen=True)
class Told:
    """A unit that does as it is told, and counts in a folder how often it was begun."""

    name: str
    folder: Path
    told: str = ""

    def check(self) -> None:
        """Return nothing."""

    def run(self) -> TimedResult:
        """Return a result, or fail, or die, always or the first time alone."""
        begun = len(list(self.folder.glob(f"{self.name}-*")))
        (self.folder / f"{self.name}-{begun}").touch()
        if self.told == "sleeps":
            (self.folder / f"pid-{os.getpid()}").touch()
            time.sleep(300)
        if self.told == "dies" or (self.told == "dies once" and not begun):
            os.kill(os.getpid(), signal.SIGKILL)
        if self.told == "refuses":
            raise InputError("cannot; write what can")
        if self.told == "breaks":
            raise ZeroDivisionError("of ours")
        return TimedResult(result=evaluate_agent("rule-2", TASK, 3), seconds=0.5)


def begun(folder: Path, name: str) -> int:
    return len(list(folder.glob(f"{name}-*")))


@pytest.mark.parametrize("workers", [1, 2])
def test_units_are_done_once_and_failures_are_kept_apart(workers: int, tmp_path: Path) -> None:
    told = {"one": "", "two": "refuses", "three": "breaks", "four": ""}
    units = [Told(name, tmp_path, what) for name, what in told.items()]
    done = {one.unit.name: one for one in run_units(units, workers)}
    assert done.keys() == told.keys()
    assert {name: one.failure for name, one in done.items() if one.outcome is None} == {
        "two": "cannot; write what can",
        "three": "ZeroDivisionError: of ours",
    }
    assert all(begun(tmp_path, name) == 1 for name in told)


def test_a_worker_that_dies_costs_no_unit_its_outcome(tmp_path: Path) -> None:
    units: list[Unit] = [Told("a", tmp_path), Told("b", tmp_path, "dies once"), Told("c", tmp_path)]
    done = list(run_units(units, workers=2))
    assert sorted(one.unit.name for one in done) == ["a", "b", "c"]
    assert all(one.outcome for one in done)
    assert begun(tmp_path, "b") == 2


def test_a_unit_that_always_kills_its_worker_is_given_up(tmp_path: Path) -> None:
    (done,) = run_units([Told("a", tmp_path, "dies")], workers=2)
    assert done.outcome is None
    assert done.failure == f"a worker process died {ATTEMPTS} times; is there enough memory?"
    assert begun(tmp_path, "a") == ATTEMPTS


def test_processes_and_this_one_give_equal_results(tmp_path: Path) -> None:
    agents = ("rule-1", "rule-4", "rule-plus")
    here, there = (
        {
            one.unit.name: one.outcome
            for one in run_units([Evaluation(agent, TASK, 40, tmp_path / str(workers)) for agent in agents], workers)
        }
        for workers in (1, 2)
    )
    for name, outcome in here.items():
        other = there[name]
        assert outcome is not None
        assert other is not None
        assert outcome.result == other.result


def test_no_worker_outlives_a_driver_that_is_killed(tmp_path: Path) -> None:
    code = (
        "from pathlib import Path; from bench.test_executors import Told; from hhrl_bench.executors import run_units\n"
        f"if __name__ == '__main__': list(run_units([Told(n, Path({str(tmp_path)!r}), 'sleeps') for n in 'ab'], 2))"
    )
    script = tmp_path / "driver.py"
    script.write_text(code)
    paths = {**os.environ, "PYTHONPATH": os.pathsep.join([str(Path(__file__).parents[1]), *sys.path])}
    with subprocess.Popen([sys.executable, str(script)], env=paths, stderr=subprocess.DEVNULL) as driver:
        wait_until(lambda: len(list(tmp_path.glob("pid-*"))) == 2)
        driver.kill()
    workers = [int(path.name.removeprefix("pid-")) for path in tmp_path.glob("pid-*")]
    wait_until(lambda: not any(is_running(worker) for worker in workers))


def wait_until(holds: Callable[[], bool], seconds: float = 60.0) -> None:
    until = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < until
        time.sleep(0.05)


def is_running(pid: int) -> bool:
    try:
        return "\nState:\tZ" not in Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return False


def test_no_worker_is_left_when_the_caller_stops(tmp_path: Path) -> None:
    running = run_units([Told(name, tmp_path) for name in "abcdef"], workers=2)
    next(running)
    running.close()  # type: ignore[attr-defined]
    wait_until(lambda: not multiprocessing.active_children())
