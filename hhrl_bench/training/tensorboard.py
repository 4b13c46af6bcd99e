"""Learning curves as TensorBoard's event files, ``tensorboard/seed-k`` in the run directory."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from torch.utils.tensorboard import SummaryWriter

from hhrl_bench.training.saved_state import ReportRow, SeedRun


class EventFiles:
    """Writes the seeds' curves, each seed a TensorBoard run, so that a chart lays them over each other.

    The curves so far are written anew and what earlier event files say is purged: no step occurs twice after a resume.
    """

    def __init__(self, folder: Path, runs: Sequence[SeedRun]) -> None:
        self._writers = {run.seed: _writer(folder / "tensorboard" / f"seed-{run.seed}") for run in runs}
        for run in runs:
            for row in run.curve:
                self.add(run.seed, row)

    def add(self, seed: int, row: ReportRow) -> None:
        """Write one report of a seed: losses, outcome rates in training, validation metrics."""
        writer = self._writers[seed]
        for tag, value in scalars(row).items():
            writer.add_scalar(tag, value, row["env_steps"])
        writer.flush()

    def close(self) -> None:
        """Close all files."""
        for writer in self._writers.values():
            writer.close()


def scalars(row: ReportRow) -> dict[str, float]:
    """Return the finite numbers of a curve's row by TensorBoard tag: ``loss/``, ``training/`` and ``validation/``."""
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


def _writer(folder: Path) -> SummaryWriter:
    return SummaryWriter(str(folder), purge_step=0)
