"""The board of a study: the folder ``progress`` among its trainings, where every process says how far its units are.

``study.json`` says what is to be done; every unit that was begun has a file of its own, written whole by whoever does
it, so that any process that sees the folder knows the state of the study: the one that hands out the work, the nodes
of a cluster, and ``hhrl-bench run --status``.
"""

import re
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal, TypeVar

from pydantic import Field, StringConstraints, ValidationError

from hhrl_agents.atomic_files import OutputError, require_writable, write_atomically
from hhrl_bench.errors import RecordError
from hhrl_bench.locks import is_locked, locked
from hhrl_bench.schema import Count, Name, Record, first_problem, sha256_of
from hhrl_envs.errors import one_line

MAX_BYTES = 16 * 2**20
LEAVING = 60.0
"""Seconds in which the workers of a run that was killed have to be gone before another one begins."""

Line = Annotated[str, StringConstraints(pattern=r"^[^\x00-\x1f\x7f-\x9f]*$", max_length=2000)]
"""Text without line ends and other control characters, which a terminal would obey."""


class StudyStatus(Record):
    """What is to be done, by whom, and since when (UTC)."""

    study: Annotated[Line, StringConstraints(min_length=1)]
    executor: Name
    started: Line
    units: tuple[Line, ...]


class UnitStatus(Record):
    """How far a unit is: ``done`` of ``total`` and a word about it, after ``seconds``; of a failed one the reason."""

    unit: Line
    state: Literal["running", "done", "failed"]
    done: Count = 0
    total: Count = 0
    note: Line = ""
    seconds: Annotated[float, Field(allow_inf_nan=False, ge=0.0)] = 0.0

    @property
    def share(self) -> float:
        """How much of it is done, from 0 to 1."""
        return 1.0 if self.state != "running" else min(self.done / self.total, 1.0) if self.total else 0.0


AnyStatus = TypeVar("AnyStatus", StudyStatus, UnitStatus)


@dataclass(frozen=True, slots=True)
class Board:
    """The board in ``folder``."""

    folder: Path

    @contextmanager
    def opened(self, study: StudyStatus) -> Iterator[None]:
        """Return a context in which this process, and no other, hands out the units of ``study``.

        Raises:
            OutputError: if another process does so in this folder, or it cannot be written.
        """
        require_writable(self._study)
        busy = f"another run works in {self.folder.parent}; wait until it has ended, or name another folder"
        leaving = f"processes of an earlier run still work in {self.folder.parent}; wait until they have ended"
        with locked(self._run_lock, busy):
            with locked(self._workers_lock, leaving, patience=LEAVING):
                self._clear()
            write_atomically(self._study, study.model_dump_json(indent=2) + "\n")
            yield

    @contextmanager
    def at_work(self) -> Iterator[None]:
        """Return a context in which this process does a unit; another run does not begin before it is left."""
        busy = f"another run begins in {self.folder.parent}"
        with locked(self._workers_lock, busy, shared=True, patience=LEAVING):
            yield

    def write(self, status: UnitStatus) -> None:
        """Return nothing; say how far a unit is, where there is room for it: the unit itself does not hang on it."""
        with suppress(OutputError):
            write_atomically(self._path(status.unit), status.model_dump_json() + "\n")

    def forget(self, unit: str) -> None:
        """Return nothing; the unit is as one that was not begun."""
        self._path(unit).unlink(missing_ok=True)

    def is_open(self) -> bool:
        """Return whether a process hands out the units now."""
        return is_locked(self._run_lock)

    def study(self) -> StudyStatus:
        """Return what is to be done.

        Raises:
            RecordError: in one line, if that does not stand here.
        """
        status = _read(self._study, StudyStatus)
        if status is None:
            raise RecordError(f"no suite was run in {self.folder.parent}; name the folder of its trainings")
        return status

    def unit(self, name: str) -> UnitStatus | None:
        """Return how far a unit is; None if it was not begun.

        Raises:
            RecordError: in one line, if something else stands in its place.
        """
        status = _read(self._path(name), UnitStatus)
        if status is not None and status.unit != one_line(name):
            raise RecordError(f"{self._path(name)} is of another unit; remove it")
        return status

    @property
    def _study(self) -> Path:
        return self.folder / "study.json"

    @property
    def _run_lock(self) -> Path:
        return self.folder / "run.lock"

    @property
    def _workers_lock(self) -> Path:
        return self.folder / "workers.lock"

    def _path(self, unit: str) -> Path:
        name = one_line(unit)
        return self.folder / f"{re.sub(r'[^A-Za-z0-9_-]+', '-', name)[:80]}-{sha256_of(name.encode())[:8]}.unit.json"

    def _clear(self) -> None:
        """Remove what an earlier run has said, and the fragments that a kill has left."""
        for pattern in ("*.unit.json", ".*.tmp"):
            for path in self.folder.glob(pattern):
                path.unlink(missing_ok=True)


def _read(path: Path, kind: type[AnyStatus]) -> AnyStatus | None:
    """Return the record in a file; None if there is no file."""
    try:
        if path.exists() and not path.is_file():
            raise RecordError(f"{path} is not a file; remove it")
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
        if len(data) > MAX_BYTES:
            raise RecordError(f"{path} is larger than {MAX_BYTES // 2**20} MiB, which no progress is; remove it")
        return kind.model_validate_json(data)
    except (FileNotFoundError, NotADirectoryError):
        return None
    except OSError as error:
        raise RecordError(f"cannot read {path}: {error.strerror}") from error
    except ValidationError as error:
        raise RecordError(f"{path} says no progress: {first_problem(error)}; remove it") from error
