"""Executors: every unit done once, failures kept apart, a unit whose worker dies or hangs begun again."""

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from multiprocessing import active_children
from pathlib import Path

import pytest

from hhrl_bench import extensions
from hhrl_bench.evaluation.records import TimedResult
from hhrl_bench.evaluation.results import silent
from hhrl_bench.execution.progress_folder import ProgressFolder
from hhrl_bench.execution.run import ATTEMPTS, Execution, Overseer, run_units
from hhrl_bench.execution.unit import Done, Unit
from hhrl_bench.suites.units import Evaluation
from support.scripted_units import TASK, ScriptedUnit, is_running

AGENTS = ("rule-1", "rule-4", "rule-plus")
TWO = Execution(workers=2)


def run(units: Sequence[Unit], execution: Execution = TWO, folder: ProgressFolder | None = None) -> dict[str, Done]:
    with execution.pool(folder) as pool:
        done = list(run_units(units, pool))
    assert sorted(one.unit.name for one in done) == sorted(unit.name for unit in units)
    return {one.unit.name: one for one in done}


def failures(done: Mapping[str, Done]) -> dict[str, str]:
    return {name: one.failure for name, one in done.items() if one.outcome is None}


@pytest.mark.parametrize("workers", [1, 2])
def test_units_are_done_once_and_failures_are_kept_apart(workers: int, tmp_path: Path) -> None:
    scripts = {"one": "", "two": "refuses", "three": "breaks", "fo\nur\x1b": ""}
    units = [ScriptedUnit(name, tmp_path, what) for name, what in scripts.items()]
    assert failures(run(units, Execution(workers=workers), ProgressFolder(tmp_path))) == {
        "two": "cannot; write what can",
        "three": "ZeroDivisionError: of ours",
    }
    assert all(unit.begun() == 1 for unit in units)


def test_a_unit_whose_worker_dies_is_begun_again_and_given_up_when_it_always_dies(tmp_path: Path) -> None:
    scripts = {"a": "", "b": "dies once", "c": "leaves once", "d": "dies", "e": "leaves"}
    units = [ScriptedUnit(name, tmp_path, what) for name, what in scripts.items()]
    assert failures(run(units)) == {
        "d": f"given up after {ATTEMPTS} attempts: its worker process was killed by signal 9; is there enough memory?",
        "e": f"given up after {ATTEMPTS} attempts: its worker process left with exit code 3",
    }
    assert [unit.begun() for unit in units] == [1, 2, 2, ATTEMPTS, ATTEMPTS]


class Knowing(Overseer):
    """An overseer that knows which units have stalled."""

    units: Sequence[ScriptedUnit] = ()

    def stalled(self, running: Iterable[str]) -> list[str]:
        """Return those that hang."""
        return [unit.name for unit in self.units if unit.name in running and unit.is_hanging()]


def test_a_unit_that_hangs_is_begun_again_and_given_up_when_it_always_hangs(tmp_path: Path) -> None:
    units = [
        ScriptedUnit("a", tmp_path, "hangs"),
        ScriptedUnit("b", tmp_path, "hangs once"),
        ScriptedUnit("c", tmp_path),
    ]
    overseer = Knowing(ProgressFolder(tmp_path), silent)
    overseer.units = units
    with TWO.pool() as pool:
        done = {one.unit.name: one for one in run_units(units, pool, overseer)}
    why = "it said nothing for longer than --unit-timeout allows"
    assert failures(done) == {"a": f"given up after {ATTEMPTS} attempts: {why}"}
    assert [unit.begun() for unit in units] == [ATTEMPTS, 2, 1]


UNITS_OF_MINE = """from support.scripted_units import ScriptedUnit


class Mine(ScriptedUnit):
    pass
"""


def test_a_worker_reads_units_whose_class_an_extension_defines(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "units_of_mine.py").write_text(UNITS_OF_MINE)
    monkeypatch.setenv(extensions.VARIABLE, "")
    monkeypatch.setattr(extensions, "_hashes", {})
    extensions.load_extensions([str(tmp_path / "units_of_mine.py")])
    module = sys.modules.pop("units_of_mine")
    monkeypatch.setitem(sys.modules, "units_of_mine", module)
    assert failures(run([module.Mine("a", tmp_path)])) == {}


def test_processes_and_this_one_give_equal_results(tmp_path: Path) -> None:
    here, there = (
        run([Evaluation(agent, TASK, 40, tmp_path / str(workers)) for agent in AGENTS], Execution(workers=workers))
        for workers in (1, 2)
    )
    for name, one in here.items():
        other = there[name].outcome
        assert isinstance(one.outcome, TimedResult)
        assert isinstance(other, TimedResult)
        assert one.outcome.result == other.result


def test_a_worker_that_dies_while_it_is_idle_costs_nothing(tmp_path: Path) -> None:
    units = [ScriptedUnit("a", tmp_path), ScriptedUnit("b", tmp_path)]
    with Execution(workers=2).pool() as pool:
        list(run_units(units[:1], pool))
        os.kill(units[0].pids()[0], 9)
        (done,) = run_units(units[1:], pool)
    assert done.outcome is not None


def test_no_worker_is_left_when_the_caller_stops(tmp_path: Path) -> None:
    units = [ScriptedUnit("a", tmp_path), ScriptedUnit("b", tmp_path, "hangs"), ScriptedUnit("c", tmp_path, "hangs")]
    with Execution(workers=2).pool() as pool:
        running = run_units(units, pool)
        next(running)
        wait_until(lambda: bool(units[1].pids()))
        pids = [process.pid for process in active_children()]
    assert len(pids) == 2
    assert not any(is_running(pid) for pid in pids if pid)
    assert not active_children()
    assert not pool.running


def test_other_children_of_the_caller_are_left_alone(tmp_path: Path) -> None:
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as other:
        run([ScriptedUnit("a", tmp_path)])
        assert other.poll() is None
        other.kill()


def test_no_worker_outlives_a_driver_that_is_killed(tmp_path: Path) -> None:
    code = (
        "from pathlib import Path; from support.scripted_units import ScriptedUnit\n"
        "from hhrl_bench.execution.run import Execution, run_units\n"
        "if __name__ == '__main__':\n"
        "    with Execution(workers=2).pool() as pool:\n"
        f"        list(run_units([ScriptedUnit(n, Path({str(tmp_path)!r}), 'hangs') for n in 'ab'], pool))\n"
    )
    script = tmp_path / "driver.py"
    script.write_text(code)
    paths = {**os.environ, "PYTHONPATH": os.pathsep.join([str(Path(__file__).parents[2]), *sys.path])}
    units = [ScriptedUnit(name, tmp_path) for name in "ab"]
    with subprocess.Popen([sys.executable, str(script)], env=paths, stderr=subprocess.DEVNULL) as driver:
        wait_until(lambda: all(unit.pids() for unit in units))
        driver.kill()
    wait_until(lambda: not any(is_running(pid) for unit in units for pid in unit.pids()))


def wait_until(holds: Callable[[], bool], seconds: float = 60.0) -> None:
    until = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < until
        time.sleep(0.05)
