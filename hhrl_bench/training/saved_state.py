"""The state of an unfinished training, and the safetensors file from which a killed training goes on, bit for bit.

The file's arrays are the learner's; its header holds what is trained and the seeds' curves, as JSON. A learner that
cannot be saved leaves no arrays, and its training starts again from the beginning.
"""

import json
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from math import inf
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save as to_bytes

from hhrl_agents.atomic_files import OutputError, write_atomically
from hhrl_envs.state import State

STATE_FORMAT, STATE_VERSION, CHECKSUM = "hhrl-training", 2, "crc32"
COST_SHARE = 20
"""A state is saved when this many times the time that saving took last has gone by."""

_UNREADABLE = (AttributeError, LookupError, OverflowError, RecursionError, TypeError, ValueError)
"""What numpy, json and the parts of a state raise where something is not as it was written."""


ReportRow = Mapping[str, Any]
"""A line of a learning curve: what one seed came to at one report, as JSON data."""


@dataclass
class SeedRun:
    """The reports of one seed of a training; ``best`` is the index of the best one, ``failed`` why the seed failed."""

    seed: int
    curve: list[ReportRow] = field(default_factory=list)
    best: int | None = None
    failed: str | None = None

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> "SeedRun":
        """Return the run that was saved as these JSON data.

        Raises:
            LookupError, TypeError, ValueError: if that cannot be.
        """
        run = cls(**data)
        for row in run.curve:
            int(row["updates"])
            if row["validation"] is not None:
                tuple(map(float, _score(row)))
        if run.best is not None and run.curve[run.best]["validation"] is None:
            raise ValueError(f"the best report of seed {run.seed} has no validation")
        return run

    @property
    def updates(self) -> int:
        """Gradient steps at the last report."""
        return int(self.curve[-1]["updates"]) if self.curve else 0

    def add(self, row: ReportRow) -> bool:
        """Add a report and return whether it is the best: more successes, then fewer collisions, then more reward."""
        self.curve.append(row)
        improved = self.best is None or _score(row) > _score(self.curve[self.best])
        if improved:
            self.best = len(self.curve) - 1
        return improved

    def fail(self, row: ReportRow) -> None:
        """Add the report that says why the seed failed."""
        self.curve.append(row)
        self.failed = row["failed"]

    def failure(self) -> dict[str, Any]:
        """Return the JSON record of a seed that failed."""
        *before, last = self.curve
        return {
            "seed": self.seed,
            "reason": self.failed,
            "env_steps": last["env_steps"],
            "last_finite_report": before[-1] if before else None,
        }


def _score(row: ReportRow) -> tuple[float, float, float]:
    validation = row["validation"]
    return validation["success"], -validation["collision"], validation["return_task"]


class TrainingState(NamedTuple):
    """A training at a report: the learner's state, the seeds' runs, and the seconds it has taken."""

    learner: State
    runs: list[SeedRun]
    seconds: float


class StateFile:
    """The file at ``path`` with the state of a training of ``config``; when it is saved changes nothing learned."""

    def __init__(self, path: Path, config: Mapping[str, Any]) -> None:
        self._path = path
        self._config = json.loads(json.dumps(config))
        self._due = -1.0

    def save_if_due(self, make: Callable[[], TrainingState]) -> None:
        """Save the state that ``make`` returns, unless saving would take more than 5% of the time."""
        started = perf_counter()
        if started < self._due:
            return
        self.save(make())
        ended = perf_counter()
        self._due = ended + COST_SHARE * (ended - started)

    def load(self, seeds: Sequence[int]) -> TrainingState:
        """Return what was saved.

        Raises:
            OutputError: if the file is damaged, or of another training.
        """
        try:
            learner, header = self._read()
            if header["config"] != self._config or [run["seed"] for run in header["runs"]] != list(seeds):
                raise self._refusal("is of another configuration or of other seeds")
            return TrainingState(learner, [SeedRun.of(run) for run in header["runs"]], _seconds(header["seconds"]))
        except OutputError:
            raise
        except (SafetensorError, OSError, *_UNREADABLE) as error:
            raise self._refusal("is damaged, or of another version") from error

    def holds(self, seeds: Sequence[int]) -> bool:
        """Return whether there is a whole state of this training there."""
        try:
            return bool(self.load(seeds))
        except OutputError:
            return False

    def refuse_learner(self, error: Exception) -> OutputError:
        """Return the error that says that the learner does not take up the state."""
        return self._refusal(f"does not fit this version's learner ({error})")

    def save(self, state: TrainingState) -> None:
        """Save a state."""
        arrays = {name: np.ascontiguousarray(array) for name, array in state.learner.items()}
        entries = {
            "format_version": STATE_VERSION,
            "config": self._config,
            "seconds": state.seconds,
            "runs": [asdict(run) for run in state.runs],
        }
        header = json.dumps(entries, allow_nan=False)
        write_atomically(self._path, to_bytes(arrays, {STATE_FORMAT: header, CHECKSUM: _checksum(arrays, header)}))

    def _read(self) -> tuple[State, dict[str, Any]]:
        with safe_open(self._path, framework="np") as file:
            metadata = file.metadata() or {}
            arrays = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
        header = dict(json.loads(metadata[STATE_FORMAT]))
        json.dumps(header, allow_nan=False)  # a ValueError, where curves hold what can be written nowhere
        if metadata[CHECKSUM] != _checksum(arrays, metadata[STATE_FORMAT]) or header["format_version"] != STATE_VERSION:
            raise self._refusal("is damaged, or of another version")
        return arrays, header

    def _refusal(self, why: str) -> OutputError:
        return OutputError(f"cannot resume: {self._path} {why}; train in another folder with --out")


def _seconds(value: float) -> float:
    if not 0.0 <= value < inf:
        raise ValueError(f"a training has taken {value} s")
    return value


def _checksum(arrays: State, header: str) -> str:
    total = zlib.crc32(header.encode())
    for name in sorted(arrays):
        total = zlib.crc32(arrays[name].data if arrays[name].size else b"", zlib.crc32(name.encode(), total))
    return str(total)
