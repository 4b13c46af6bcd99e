"""Sweeps that are killed at any moment go on: nothing is lost, done twice or half written."""

import os
import resource
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

from support.sweeps import finish, outcomes, results, start, workers_of

KILLS = int(os.environ.get("HHRL_KILLS", "2"))
"""How often the run is killed; ``make kills`` does it more often."""

LIMIT = 30_000
"""Bytes that a file may have on a file system that is full: less than a training's state has."""


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, float]:
    """Return the folder of a run that nothing has disturbed, and the seconds it took."""
    folder, started = tmp_path_factory.mktemp("undisturbed"), time.monotonic()
    code, said = finish("four", folder, "--workers", "2")
    assert code == 0, said
    return folder, time.monotonic() - started


def test_a_sweep_that_is_killed_goes_on_with_nothing_lost_doubled_or_half_written(
    undisturbed: tuple[Path, float], tmp_path: Path
) -> None:
    whole, seconds = undisturbed
    moments = np.random.default_rng(7).uniform(0.1, 0.9, KILLS) * seconds
    done: dict[Path, int] = {}
    for moment in moments:
        with start("four", tmp_path, "--workers", "2", stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL) as driver:
            time.sleep(moment)
            driver.kill()
        before, done = done, outcomes(tmp_path)
        assert before.items() <= done.items()  # what was finished stays, and is not done again
    code, said = finish("four", tmp_path, "--workers", "2")
    assert code == 0, said
    assert done.items() <= outcomes(tmp_path).items()
    assert results(tmp_path) == results(whole)


def test_a_full_disk_is_one_line_and_the_run_goes_on_when_there_is_room(
    undisturbed: tuple[Path, float], tmp_path: Path
) -> None:
    whole, _ = undisturbed

    def fill() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (LIMIT, resource.RLIM_INFINITY))

    code, said = finish("four", tmp_path, "--workers", "2", preexec_fn=fill)
    assert code == 1
    failed = [line for line in said.splitlines() if " failed: " in line]
    assert len(failed) == 2
    assert all("File too large; make room there, and run the same command again" in line for line in failed)
    assert len(outcomes(tmp_path)) == 2  # the rules'
    code, said = finish("four", tmp_path, "--workers", "2")
    assert code == 0, said
    assert results(tmp_path) == results(whole)


def test_a_second_run_in_the_same_folder_is_one_line_and_exit_code_2(tmp_path: Path) -> None:
    with start("four", tmp_path, "--workers", "2") as first:
        while not (tmp_path / "work" / "progress" / "study.json").exists():
            assert first.poll() is None
            time.sleep(0.05)
        first.send_signal(signal.SIGSTOP)
        code, said = finish("four", tmp_path, "--workers", "2")
        first.kill()
    assert code == 2
    assert said.splitlines()[-1].startswith(f"hhrl-bench: another run works in {tmp_path / 'work'};")
    assert len([line for line in said.splitlines() if "compiling" not in line]) == 1


def test_an_interrupt_is_one_line_and_leaves_no_worker(tmp_path: Path) -> None:
    def heed() -> None:  # of tests that run in the background, interrupts may be ignored, which is passed on
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    with start("four", tmp_path, "--workers", "2", start_new_session=True, preexec_fn=heed) as driver:
        while not list((tmp_path / "work").rglob("*.unit.json")):
            assert driver.poll() is None
            time.sleep(0.05)
        assert workers_of(driver.pid)
        os.killpg(driver.pid, signal.SIGINT)  # as a terminal does it: the workers hear of it too
        _, said = driver.communicate()
    assert driver.returncode == 130
    assert said.splitlines()[-1] == "hhrl-bench: interrupted; what was not finished was not written"
    assert "Traceback" not in said
    assert not workers_of(driver.pid)
