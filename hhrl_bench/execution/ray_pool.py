"""The Ray pool: the processes of a Ray cluster, one thread each; every node has to see the same folders."""

import os
import socket
from collections.abc import Collection
from functools import cache
from pathlib import Path
from typing import Any

from hhrl_bench.errors import ClusterError
from hhrl_bench.execution.progress_board import Board
from hhrl_bench.execution.unit import Done, Unit, attempt
from hhrl_bench.provenance import software
from hhrl_envs.errors import InputError, require

MOST = 10_000
"""Units that the cluster has at a time; it begins as many of them as it has cores."""


class RayPool:
    """The cluster at ``address``; by default the one that this machine belongs to, or else one of this machine alone.

    A unit whose node or process is lost is not begun again by Ray; see :class:`hhrl_bench.execution.pool.Pool`.
    """

    def __init__(self, address: str | None, board: Board | None) -> None:
        require("ray", "ray")
        import ray  # noqa: PLC0415

        if address and address not in {"auto", "local"}:
            _require_listener(address)
        try:
            ray.init(address, log_to_driver=False, logging_level="ERROR")
        except (ConnectionError, RuntimeError, ValueError, ray.exceptions.RayError) as error:
            raise ClusterError(f"cannot join the Ray cluster: {error}; see docs/sweeps.md") from error
        self._ray, self._board = ray, board
        self._task = ray.remote(num_cpus=1, max_retries=0)(attempt_there)
        self._units: dict[Any, Unit] = {}
        self._reasons: dict[Any, str] = {}

    @property
    def free(self) -> int:
        """How many units more it takes."""
        return MOST - len(self._units)

    @property
    def running(self) -> Collection[Unit]:
        """The units that it was given, of which some may have to wait for a core."""
        return self._units.values()

    def begin(self, unit: Unit) -> None:
        """Return nothing; hand the unit to the cluster."""
        self._units[self._task.remote(unit, self._board, Path.cwd(), software())] = unit

    def wait(self, seconds: float) -> list[Done]:
        """Return the units that have ended, and those whose node or process is gone as lost."""
        some, _ = self._ray.wait(list(self._units), timeout=seconds)
        ended, _ = self._ray.wait(list(self._units), num_returns=len(self._units), timeout=0) if some else (some, None)
        return [self._ended(reference) for reference in ended]

    def stop(self, unit: Unit, reason: str) -> None:
        """Return nothing; end the process that does the unit."""
        for reference in [reference for reference, one in self._units.items() if one is unit]:
            self._reasons[reference] = reason
            self._ray.cancel(reference, force=True)

    def close(self) -> None:
        """Return nothing; end what the cluster is doing for this process, and leave it."""
        for reference in self._units:
            self._ray.cancel(reference, force=True)
        self._ray.shutdown()

    def _ended(self, reference: Any) -> Done:
        unit, reason = self._units.pop(reference), self._reasons.pop(reference, "")
        errors = self._ray.exceptions
        try:
            done: Done = self._ray.get(reference)
        except errors.RayTaskError as error:
            return Done(unit, None, str(error.cause))
        except errors.RayError as error:
            return Done(unit, None, reason or f"its node or process was lost ({type(error).__name__})", lost=True)
        return done._replace(unit=unit)


def _require_listener(address: str) -> None:
    """Return nothing; Ray itself would wait for minutes, and then end this process."""
    host, _, port = address.rpartition(":")
    try:
        socket.create_connection((host, int(port)), timeout=10.0).close()
    except (OSError, OverflowError, ValueError) as error:
        raise ClusterError(f"no Ray cluster answers at {address}; start one with: ray start --head") from error


def attempt_there(unit: Unit, board: Board | None, folder: Path, versions: dict[str, str]) -> Done:
    """Return the unit as a node has done it from this folder, if it has these versions and sees the board."""
    try:
        _require_same(_software(), versions)
        os.chdir(folder)
        if board is not None:
            board.study()
    except (OSError, InputError) as error:
        return Done(unit, None, f"node {socket.gethostname()}: {error}; all nodes need the same folders and versions")
    return attempt(unit, board)


@cache
def _software() -> dict[str, str]:
    return software()


def _require_same(here: dict[str, str], there: dict[str, str]) -> None:
    for name in sorted({*here, *there}):
        if here.get(name) != there.get(name):
            raise ClusterError(f"{name} is {here.get(name)} here and {there.get(name)} where the suite was started")
