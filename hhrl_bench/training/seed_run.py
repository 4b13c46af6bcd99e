"""One seed of a training: its learning curve, which report was its best, and why it failed, if it did."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

Row = Mapping[str, Any]


@dataclass
class SeedRun:
    """What a seed's reports have come to; `best` is the place of the best one in the curve."""

    seed: int
    curve: list[Row] = field(default_factory=list)
    best: int | None = None
    failed: str | None = None

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> "SeedRun":
        """Return the run that has been saved as these JSON data.

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

    def add(self, row: Row) -> bool:
        """Return whether this report is the best so far: more successes, then fewer collisions, then more reward."""
        self.curve.append(row)
        improved = self.best is None or _score(row) > _score(self.curve[self.best])
        if improved:
            self.best = len(self.curve) - 1
        return improved

    def fail(self, row: Row) -> None:
        """Return nothing; add the report that says why the seed has failed."""
        self.curve.append(row)
        self.failed = row["failed"]

    def failure(self) -> dict[str, Any]:
        """Return the JSON record of a seed that has failed."""
        *before, last = self.curve
        return {
            "seed": self.seed,
            "reason": self.failed,
            "env_steps": last["env_steps"],
            "last_finite_report": before[-1] if before else None,
        }


def find_fault(losses: Mapping[str, float], finite_parameters: bool, updated: bool) -> str | None:
    """Return why a seed has diverged, by its mean losses since its last report and its parameters; None if neither."""
    if not finite_parameters:
        return "its parameters are not finite"
    lost = [level for level, loss in losses.items() if updated and not math.isfinite(loss)]
    return f"its {lost[0]} loss is not finite" if lost else None


def _score(row: Row) -> tuple[float, float, float]:
    validation = row["validation"]
    return validation["success"], -validation["collision"], validation["return_task"]
