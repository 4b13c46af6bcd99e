"""Trainings that take a second: small networks, many reports. As a script it is the command line with those."""

import itertools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from hhrl_bench.cli import main
from hhrl_bench.tasks.tasks import get_task
from hhrl_bench.training import train as training
from support import configs

TASK = get_task("stop-line-v0")
STEPS = 600
CONFIG: dict[str, Any] = {
    "hidden": (8,),
    "n_envs": 4,
    "batch_size": 8,
    "replay_capacity": 400,
    "warmup": 40,
    "target_interval": 10,
    "report_every": 200,
}


@contextmanager
def small_methods() -> Iterator[pytest.MonkeyPatch]:
    """Return a context in which every method trains small networks, validated on few episodes."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(training, "METHODS", configs.small_methods(CONFIG))
        patch.setattr(training, "VALIDATION_EPISODES", 16)
        yield patch


def plan(folder: Path, seeds: tuple[int, ...] = (0, 2), method: str = "ddqn", env_steps: int = STEPS) -> training.Plan:
    """Return the plan of a small training."""
    return training.Plan(training.get_method(method), TASK, seeds, env_steps, folder)


def contents(folder: Path) -> dict[str, bytes]:
    """Return the files of a run directory but for its provenance, whose clock differs."""
    files = (path for path in folder.iterdir() if path.is_file() and not path.name.startswith("provenance"))
    return {path.name: path.read_bytes() for path in files}


class KillError(BaseException):
    """The process ends here, whatever is tried."""


def killed_at(write: int, train: Callable[[], object], monkeypatch: pytest.MonkeyPatch) -> bool:
    """Return whether a training was killed right after it has put its n-th file in place."""
    writes, replace = itertools.count(), Path.replace

    def killing(self: Path, target: Path) -> Path:
        replace(self, target)
        if next(writes) == write:
            raise KillError
        return target

    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", killing)
        try:
            train()
        except KillError:
            return True
    return False


if __name__ == "__main__":
    with small_methods():
        main()
