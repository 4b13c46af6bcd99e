"""Trackers: learning curves for TensorBoard, Weights & Biases or MLflow, beside those of the run directory.

Each training seed is a run of the tracker. When a training is resumed the curves so far are written anew, so that no
step is there twice. All is written into the run directory, and nothing is sent anywhere.
"""

import os
import shutil
import time
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from hhrl_bench.training.saved_state import ReportRow, SeedRun
from hhrl_envs.errors import require, require_value

Config = Mapping[str, Any]
"""What all seeds of a training share, as JSON data."""

PROJECT = "hhrl-bench"
"""What the runs belong to in a tracker."""


class Tracker(ABC):
    """Writes the seeds' curves. To add one, derive from this, and name it in ``TRACKERS``.

    Attributes:
        modules: what it imports.
        extra: the extra that brings these.
    """

    modules: tuple[str, ...]
    extra: str

    def __init__(self, folder: Path, runs: Sequence[SeedRun], config: Config) -> None:
        """Begin a run for every seed in the run directory ``folder``, and write the curves so far."""
        self._opened = {run.seed: self.begin(folder, run.seed, config) for run in runs}
        for run in runs:
            for row in run.curve:
                self.add(run.seed, row)

    def add(self, seed: int, row: ReportRow) -> None:
        """Write one report of a seed: losses, outcome rates in training, validation metrics."""
        self.write(self._opened[seed], scalars(row), int(row["env_steps"]))

    def close(self) -> None:
        """End all runs."""
        for run in self._opened.values():
            self.end(run)

    @abstractmethod
    def begin(self, folder: Path, seed: int, config: Config) -> Any:
        """Return a new run of a seed, in place of one that was begun before a stop."""

    @abstractmethod
    def write(self, run: Any, numbers: Mapping[str, float], step: int) -> None:
        """Write numbers by their tags at an environment step."""

    @abstractmethod
    def end(self, run: Any) -> None:
        """End a run; nothing is written to it any more."""


class TensorBoard(Tracker):
    """Event files in ``tensorboard/seed-k``: a chart lays the seeds over each other."""

    modules, extra = ("torch", "tensorboard"), "tensorboard"

    def begin(self, folder: Path, seed: int, config: Config) -> Any:
        """Return a writer; what earlier event files say is purged."""
        from torch.utils.tensorboard import SummaryWriter  # noqa: PLC0415

        return SummaryWriter(str(folder / "tensorboard" / f"seed-{seed}"), purge_step=0)

    def write(self, run: Any, numbers: Mapping[str, float], step: int) -> None:
        """Write numbers by their tags at an environment step."""
        for tag, value in numbers.items():
            run.add_scalar(tag, value, step)
        run.flush()

    def end(self, run: Any) -> None:
        """Close the file."""
        run.close()


class WeightsAndBiases(Tracker):
    """Offline runs in ``wandb/seed-k``, which ``wandb sync`` uploads."""

    modules, extra = ("wandb",), "wandb"

    def begin(self, folder: Path, seed: int, config: Config) -> Any:
        """Return an offline run."""
        os.environ.setdefault("WANDB_ERROR_REPORTING", "false")  # it would use the network while it is imported
        import wandb  # noqa: PLC0415

        place = folder / "wandb" / f"seed-{seed}"
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir(parents=True)
        return wandb.init(
            project=PROJECT,
            group=folder.name,
            name=f"{folder.name} seed {seed}",
            config={**config, "seed": seed},
            dir=str(place),
            mode="offline",
            reinit="create_new",
            settings=wandb.Settings(silent=True, console="off", x_disable_stats=True),
        )

    def write(self, run: Any, numbers: Mapping[str, float], step: int) -> None:
        """Write numbers by their tags at an environment step."""
        run.log(dict(numbers), step=step)

    def end(self, run: Any) -> None:
        """Finish the run."""
        run.finish()


class MLflow(Tracker):
    """Runs in the SQLite file ``mlflow.db``, which ``mlflow ui --backend-store-uri sqlite:///...`` shows."""

    modules, extra = ("mlflow",), "mlflow"

    def __init__(self, folder: Path, runs: Sequence[SeedRun], config: Config) -> None:
        """Make the file unless it is there: other seeds may be in it."""
        os.environ.setdefault("MLFLOW_DISABLE_TELEMETRY", "true")
        from mlflow import MlflowClient  # noqa: PLC0415

        self._client: Any = MlflowClient(tracking_uri=f"sqlite:///{(folder / 'mlflow.db').absolute()}")
        known = self._client.get_experiment_by_name(PROJECT)
        artifacts = (folder / "mlflow").absolute().as_uri()
        self._experiment = (
            known.experiment_id if known else self._client.create_experiment(PROJECT, artifact_location=artifacts)
        )
        super().__init__(folder, runs, config)

    def begin(self, folder: Path, seed: int, config: Config) -> Any:
        """Return the id of a new run, which has the settings that are single values."""
        for earlier in self._client.search_runs([self._experiment], f"params.seed = '{seed}'"):
            self._client.delete_run(earlier.info.run_id)
        run = self._client.create_run(self._experiment, run_name=f"{folder.name} seed {seed}").info.run_id
        for name, value in {**config, "method": config["method"]["id"], "seed": seed}.items():
            if isinstance(value, str | int | float):
                self._client.log_param(run, name, value)
        return run

    def write(self, run: Any, numbers: Mapping[str, float], step: int) -> None:
        """Write numbers by their tags at an environment step."""
        from mlflow.entities import Metric  # noqa: PLC0415

        now = int(1000 * time.time())
        self._client.log_batch(run, metrics=[Metric(tag, value, now, step) for tag, value in numbers.items()])

    def end(self, run: Any) -> None:
        """Mark the run as finished."""
        self._client.set_terminated(run)


TRACKERS: Mapping[str, type[Tracker]] = MappingProxyType(
    {"tensorboard": TensorBoard, "wandb": WeightsAndBiases, "mlflow": MLflow}
)
"""The trackers by their names."""


def require_trackers(names: Sequence[str]) -> None:
    """Raise an ``InputError`` for a name that is no tracker's, or one whose extra is missing."""
    for name in names:
        require_value(name in TRACKERS, "the tracker", repr(name), f"one of {', '.join(TRACKERS)}")
        for module in TRACKERS[name].modules:
            require(module, TRACKERS[name].extra)


def scalars(row: ReportRow) -> dict[str, float]:
    """Return the finite numbers of a curve's row by their tags: ``loss/``, ``training/`` and ``validation/``."""
    episodes: Mapping[str, int] = row["episodes"]
    rates = {outcome: count / sum(episodes.values()) for outcome, count in episodes.items()}
    groups: Mapping[str, Mapping[str, Any]] = {
        "loss": row["losses"],
        "training": rates,
        "validation": row["validation"] or {},
    }
    return {
        f"{group}/{name}": float(value)
        for group, numbers in groups.items()
        for name, value in numbers.items()
        if value is not None
    }
