"""A Ray cluster of three nodes on this machine: results equal to the local executor's while one node is killed."""

import os
import secrets
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from hhrl_bench.errors import RecordError
from hhrl_bench.evaluation.results import silent
from hhrl_bench.execution.progress_folder import ProgressFolder, StudyStatus, UnitStatus
from hhrl_bench.execution.run import ATTEMPTS, Execution, Overseer, run_units
from support.scripted_units import ScriptedUnit, is_running
from support.sweeps import environment, finish, results, start

pytest.importorskip("ray", reason="ray is not installed; run: make cluster")

MARK = "HHRL_TEST_CLUSTER"
"""Stands in the environment of every process of the cluster, so that exactly those are ended."""

NODES = ("one", "two", "three")


class Cluster(NamedTuple):
    """The address of a cluster, the mark of its processes, and the file with the token that they ask for."""

    address: str
    mark: str
    token: Path

    @property
    def options(self) -> tuple[str, ...]:
        """The options of a run on it."""
        return "--executor", "ray", "--address", self.address

    @property
    def access(self) -> dict[str, str]:
        """The environment of a process that may join."""
        return {"RAY_AUTH_MODE": "token", "RAY_AUTH_TOKEN_PATH": str(self.token)}

    def processes(self, word: str = "") -> list[int]:
        """Return its processes whose command holds a word."""
        return [int(path.name) for path in Path("/proc").glob("[0-9]*") if self._has(path, word)]

    def kill(self, word: str = "") -> None:
        """Return when no such process is left."""
        while pids := self.processes(word):
            for pid in pids:
                os.kill(pid, signal.SIGKILL)
            time.sleep(0.1)

    def _has(self, process: Path, word: str) -> bool:
        try:
            marked = f"{MARK}={self.mark}".encode() in (process / "environ").read_bytes().split(b"\0")
            return marked and word.encode() in (process / "cmdline").read_bytes() and is_running(int(process.name))
        except OSError:
            return False


@pytest.fixture
def cluster() -> Iterator[Cluster]:
    """Return a cluster of three nodes of one core, each begun by ``ray start``."""
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        port = one.getsockname()[1]
    with tempfile.TemporaryDirectory(prefix="ray") as folder:  # short: sockets lie in it
        cluster = Cluster(f"127.0.0.1:{port}", f"{os.getpid()}-{port}", Path(folder) / "token")
        cluster.token.write_text(secrets.token_hex(32))
        head = [
            "--head",
            "--include-dashboard=false",
            f"--port={port}",
            "--node-ip-address=127.0.0.1",
            f"--temp-dir={folder}",
        ]
        try:
            for name in NODES:
                place = head if name == NODES[0] else [f"--address={cluster.address}"]
                ray_start(cluster, f"--node-name={name}", *place)
            yield cluster
        finally:
            cluster.kill()


def ray_start(cluster: Cluster, *options: str) -> None:
    size = ["--num-cpus=1", "--num-gpus=0", "--object-store-memory=100000000"]
    program = Path(sys.executable).with_name("ray")
    more = {MARK: cluster.mark, "OMP_NUM_THREADS": "1", **cluster.access}
    command = [str(program), "start", "--disable-usage-stats", *size, *options]
    done = subprocess.run(command, env=environment(**more), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_a_cluster_that_loses_a_node_gives_the_results_of_one_machine(cluster: Cluster, tmp_path: Path) -> None:
    local, far = tmp_path / "local", tmp_path / "far"
    progress = ProgressFolder(far / "work" / "progress")
    with start(
        "forty", far, "--executor", "ray", "--address", cluster.address, env=environment(**cluster.access)
    ) as driver:
        wait_until(lambda: driver.poll() is not None or sum(one.state == "running" for one in trainings(progress)) == 3)
        assert len(cluster.processes("--node-name=three")) > 0
        cluster.kill("--node-name=three")
        _, said = driver.communicate()
    assert driver.returncode == 0, said
    code, said = finish("forty", local, "--workers", "2")
    assert code == 0, said
    assert results(far) == results(local)
    assert len(list(far.rglob("result-*.json"))) == 40


def test_a_driver_that_is_killed_leaves_no_task_and_its_run_goes_on(cluster: Cluster, tmp_path: Path) -> None:
    progress = ProgressFolder(tmp_path / "work" / "progress")
    with start(
        "four", tmp_path, "--executor", "ray", "--address", cluster.address, env=environment(**cluster.access)
    ) as driver:
        wait_until(lambda: driver.poll() is not None or any(one.done > 0 for one in trainings(progress)))
        driver.kill()
    code, said = finish(
        "four", tmp_path, "--executor", "ray", "--address", cluster.address, env=environment(**cluster.access)
    )
    assert code == 0, said
    assert len(list(tmp_path.rglob("result-*.json"))) == 4


def test_ray_and_processes_tell_the_same_faults(tmp_path: Path) -> None:
    scripts = {"a": "", "b": "dies once", "c": "dies", "d": "refuses", "e": "breaks", "f": "hangs", "g": "hangs once"}
    units = [ScriptedUnit(name, tmp_path, what) for name, what in scripts.items()]
    progress = ProgressFolder(tmp_path / "progress")
    study = StudyStatus(study="faults", executor="ray", started="", units=tuple(scripts))
    with progress.opened(study), Execution("ray", address="local").pool(progress) as pool:
        overseer = Overseer(progress, silent, patience=20.0)
        done = {one.unit.name: one for one in run_units(units, pool, overseer)}
    assert {name for name, one in done.items() if one.outcome} == {"a", "b", "g"}
    given_up = f"given up after {ATTEMPTS} attempts: "
    assert done["c"].failure.startswith(f"{given_up}its node or process was lost")
    assert done["d"].failure == "cannot; write what can"
    assert done["e"].failure == "ZeroDivisionError: of ours"
    assert done["f"].failure == f"{given_up}it said nothing for longer than --unit-timeout allows"
    assert [unit.begun() for unit in units] == [1, 2, ATTEMPTS, 1, 1, ATTEMPTS, 2]


def test_no_cluster_is_one_line(tmp_path: Path) -> None:
    code, said = finish("four", tmp_path, "--executor", "ray", "--address", "127.0.0.1:1")
    assert code == 2
    assert "no Ray cluster answers at 127.0.0.1:1; start one with: ray start --head" in said
    assert "Traceback" not in said


def trainings(progress: ProgressFolder) -> list[UnitStatus]:
    try:
        units = [progress.unit(name) for name in progress.study().units if not name.startswith("rule")]
    except RecordError:
        return []
    return [one for one in units if one]


def wait_until(holds: Callable[[], bool], seconds: float = 300.0) -> None:
    until = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < until
        time.sleep(0.1)
