"""The folder ``progress`` beside the trainings of a study, in which every process writes how far its units are.

``study.json`` says what is to be done. Every unit that was begun has a file of its own, written whole by the process
that does it, so that any process that sees the folder knows the state of the study: the one that hands out the units,
the nodes of a cluster, and ``hhrl-bench run --status``.
"""

import re
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal, TypeVar

from filelock import FileLock, Timeout
from pydantic import Field, StringConstraints, ValidationError

from hhrl_agents.atomic_files import (
    OutputError,
    made_folder,
    remove_fragments,
    require_writable,
    write_atomically,
)
from hhrl_bench.errors import RecordError
from hhrl_bench.locks import locked
from hhrl_bench.schema import Count, Name, Record, first_problem, sha256_of
from hhrl_envs.errors import one_line

MAX_PROGRESS_BYTES = 16 * 2**20
"""A larger file is no progress."""

RUN_PATIENCE = 1.0
"""Seconds that a run waits for another one to let go of the folder."""

WORKER_PATIENCE = 60.0
"""Seconds in which the processes of a run that was killed have to be gone before another one begins."""

TextLine = Annotated[str, StringConstraints(pattern=r"^[^\x00-\x1f\x7f-\x9f]*$", max_length=2000)]
"""Text without line ends and other control characters, which a terminal would obey."""


class StudyStatus(Record):
    """What is to be done, by whom, and since when (UTC)."""

    study: Annotated[TextLine, StringConstraints(min_length=1)]
    executor: Name
    started: TextLine
    units: tuple[TextLine, ...]


class UnitStatus(Record):
    """How far a unit is: ``done`` of ``total`` and a word about it, after ``seconds``; of a failed one the reason."""

    unit: TextLine
    state: Literal["running", "done", "failed"]
    done: Count = 0
    total: Count = 0
    note: TextLine = ""
    seconds: Annotated[float, Field(allow_inf_nan=False, ge=0.0)] = 0.0

    @property
    def share(self) -> float:
        """How much of it is done, from 0 to 1."""
        return 1.0 if self.state != "running" else min(self.done / self.total, 1.0) if self.total else 0.0


AnyStatus = TypeVar("AnyStatus", StudyStatus, UnitStatus)


@dataclass(frozen=True, slots=True)
class ProgressFolder:
    """The progress folder at ``path``."""

    path: Path

    @classmethod
    def within(cls, work: Path) -> "ProgressFolder":
        """Return the progress folder of the study whose trainings lie in the folder ``work``."""
        return cls(work / "progress")

    @contextmanager
    def opened(self, study: StudyStatus) -> Iterator[None]:
        """Let this process, and no other, hand out the units of ``study`` in this context.

        If it fails before a unit has begun, nothing is left of it.

        Raises:
            OutputError: if another process does so in this folder, or it cannot be written.
        """
        require_writable(self._study)
        busy = f"another run works in {self.path.parent}; wait until it has ended, or name another folder"
        with made_folder(self.path), locked(self._run_lock, busy, RUN_PATIENCE, passing=True):
            self._clear()
            write_atomically(self._study, study.model_dump_json(indent=2) + "\n")
            try:
                yield
            except BaseException:
                if not any(self.path.glob("*.unit.json")):
                    self._study.unlink(missing_ok=True)
                raise

    @contextmanager
    def at_work(self) -> Iterator[None]:
        """Let this process do a unit in this context; another run does not begin before it is left.

        Each has a lock of its own: a file server may keep that of a node that was lost for a while, which must not
        keep another one from doing the unit.
        """
        lock = self.path / f"{secrets.token_hex(8)}.worker.lock"
        with locked(lock, f"another process has {lock}", 0.0):
            yield
        with suppress(OSError):
            lock.unlink()

    def write(self, status: UnitStatus) -> None:
        """Write how far a unit is, if there is room for it: the unit itself does not depend on it."""
        with suppress(OutputError):
            write_atomically(self._file(status.unit), status.model_dump_json() + "\n")

    def forget(self, unit: str) -> None:
        """Remove what was written about a unit, as if it had not begun."""
        self._file(unit).unlink(missing_ok=True)

    def is_open(self) -> bool:
        """Return whether a process hands out units now."""
        try:
            if self._run_lock.is_file():
                with FileLock(self._run_lock, timeout=0):
                    pass
        except Timeout:
            return True
        except OSError:
            return False
        return False

    def study(self) -> StudyStatus:
        """Return what is to be done.

        Raises:
            RecordError: in one line, if there is no study here.
        """
        status = _read(self._study, StudyStatus)
        if status is None:
            raise RecordError(f"no suite was run in {self.path.parent}; name the folder of its trainings")
        return status

    def unit(self, name: str) -> UnitStatus | None:
        """Return how far a unit is; None if it has not begun.

        Raises:
            RecordError: in one line, if something else stands in its place.
        """
        path = self._file(name)
        status = _read(path, UnitStatus)
        if status is not None and status.unit != one_line(name):
            raise RecordError(f"{path} is of another unit; remove it")
        return status

    @property
    def _study(self) -> Path:
        return self.path / "study.json"

    @property
    def _run_lock(self) -> Path:
        return self.path / "run.lock"

    def _file(self, unit: str) -> Path:
        name = one_line(unit)
        return self.path / f"{re.sub(r'[^A-Za-z0-9_-]+', '-', name)[:80]}-{sha256_of(name.encode())[:8]}.unit.json"

    def _clear(self) -> None:
        """Remove what an earlier run has left, once its processes have ended."""
        busy = f"processes of an earlier run still work in {self.path.parent}; wait until they have ended"
        for lock in self.path.glob("*.worker.lock"):
            with locked(lock, busy, WORKER_PATIENCE):
                lock.unlink(missing_ok=True)
        remove_fragments(self.path)
        for path in self.path.glob("*.unit.json"):
            path.unlink(missing_ok=True)


def _read(path: Path, kind: type[AnyStatus]) -> AnyStatus | None:
    """Return the record in a file; None if there is no file."""
    try:
        if path.exists() and not path.is_file():
            raise RecordError(f"{path} is not a file; remove it")
        with path.open("rb") as file:
            data = file.read(MAX_PROGRESS_BYTES + 1)
        if len(data) > MAX_PROGRESS_BYTES:
            raise RecordError(
                f"{path} is larger than {MAX_PROGRESS_BYTES // 2**20} MiB, which no progress is; remove it"
            )
        return kind.model_validate_json(data)
    except (FileNotFoundError, NotADirectoryError):
        return None
    except OSError as error:
        raise RecordError(f"cannot read {path}: {error.strerror}") from error
    except ValidationError as error:
        raise RecordError(f"{path} says no progress: {first_problem(error)}; remove it") from error
