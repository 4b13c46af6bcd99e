"""The state of an unfinished training: one safetensors file, so that a killed training goes on, bit for bit.

Its arrays are the learner's; its header holds what is trained and the seeds' curves, as JSON. A learner that cannot be
saved leaves no arrays, and its training starts again from the beginning.
"""

import json
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from math import inf
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save as to_bytes

from hhrl_agents.atomic_files import OutputError, write_atomically
from hhrl_bench.training.seed_run import SeedRun
from hhrl_envs.state import State

FORMAT, FORMAT_VERSION, CHECKSUM = "hhrl-training", 1, "crc32"
COST_SHARE = 20
"""A state is saved when this many times the time that saving took last has gone by."""

_UNREADABLE = (AttributeError, LookupError, OverflowError, RecursionError, TypeError, ValueError)
"""What numpy, json and the parts of a state raise where something is not as it was written."""


class TrainingState(NamedTuple):
    """A training at a report: the learner's state, the seeds' runs, and the seconds it has taken."""

    learner: State
    runs: list[SeedRun]
    seconds: float


class StateFile:
    """The file at ``path`` for a training of ``config``; which moments are saved does not change what is learned."""

    def __init__(self, path: Path, config: Mapping[str, Any]) -> None:
        self._path = path
        self._config = json.loads(json.dumps(config))
        self._due = -1.0

    def save_if_due(self, make: Callable[[], TrainingState]) -> None:
        """Return nothing; save what ``make`` returns, unless that would take more than 5% of the time."""
        started = perf_counter()
        if started < self._due:
            return
        self._write(make())
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

    def refuse_learner(self, error: Exception) -> OutputError:
        """Return the error that says that the learner does not take up the state."""
        return self._refusal(f"does not fit this version's learner ({error})")

    def _write(self, state: TrainingState) -> None:
        arrays = {name: np.ascontiguousarray(array) for name, array in state.learner.items()}
        entries = {
            "format_version": FORMAT_VERSION,
            "config": self._config,
            "seconds": state.seconds,
            "runs": [asdict(run) for run in state.runs],
        }
        header = json.dumps(entries, allow_nan=False)
        write_atomically(self._path, to_bytes(arrays, {FORMAT: header, CHECKSUM: _checksum(arrays, header)}))

    def _read(self) -> tuple[State, dict[str, Any]]:
        with safe_open(self._path, framework="np") as file:
            metadata = file.metadata() or {}
            arrays = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
        header = dict(json.loads(metadata[FORMAT]))
        json.dumps(header, allow_nan=False)  # a ValueError, where curves hold what can be written nowhere
        if metadata[CHECKSUM] != _checksum(arrays, metadata[FORMAT]) or header["format_version"] != FORMAT_VERSION:
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
