"""How the episodes of a training ended, read from its run directory."""

import json
import re
from collections.abc import Callable, Sequence
from pathlib import Path

from pydantic import BaseModel, ValidationError

from hhrl_bench.errors import CurveError
from hhrl_bench.records import Count, Rate, first_problem
from hhrl_bench.run_directory import RunDirectory
from hhrl_bench.training_records import OUTCOMES, Shares, SharesRecord, TrainingOutcomesRecord


class _Validation(BaseModel):
    success: Rate
    timeout: Rate
    not_stop: Rate
    collision: Rate


class _Report(BaseModel):
    """What is read of a line of a curve file."""

    env_steps: Count
    episodes: dict[str, Count]
    validation: _Validation | None

    def trained(self, outcome: str) -> float | None:
        total = sum(self.episodes.values())
        return self.episodes.get(outcome, 0) / total if total else None

    def tested(self, outcome: str) -> float | None:
        return getattr(self.validation, outcome, None)


def read_outcomes(folder: Path, seeds: Sequence[int] = ()) -> TrainingOutcomesRecord:
    """Return the outcomes of these seeds of a run directory, or of all that it has; they may be under way.

    Raises:
        CurveError: if it lacks the curve of a seed, or holds ones that are damaged or have different reports.
    """
    method, task = _trained(folder)
    curves = {seed: _read(RunDirectory(folder).curve(seed)) for seed in sorted(seeds or _seeds(folder))}
    env_steps = max(([report.env_steps for report in curve] for curve in curves.values()), key=len, default=[])
    if not env_steps:
        raise CurveError(f"{folder} holds no learning curves; name a folder that hhrl-bench train has filled")
    for seed, curve in curves.items():
        if [report.env_steps for report in curve] != env_steps[: len(curve)]:
            raise CurveError(
                f"the reports of seed {seed} in {folder} are at other env steps than those of another seed"
            )
    table = [[*curve, *[None] * (len(env_steps) - len(curve))] for curve in curves.values()]
    try:
        return TrainingOutcomesRecord(
            method=method,
            task=task,
            seeds=tuple(curves),
            env_steps=tuple(env_steps),
            training=_shares(table, _Report.trained),
            testing=_shares(table, _Report.tested),
        )
    except ValidationError as error:
        raise CurveError(f"the learning curves in {folder} are damaged: {first_problem(error)}") from error


def _trained(folder: Path) -> tuple[str, str]:
    """Return the method and the task of a run directory."""
    try:
        config = json.loads((folder / "config.json").read_text(encoding="utf-8"))
        return str(config["method"]["id"]), str(config["task"])
    except (OSError, KeyError, TypeError, ValueError, RecursionError) as error:
        raise CurveError(
            f"{folder} has no config.json to read; name a folder that hhrl-bench train has filled"
        ) from error


def _seeds(folder: Path) -> list[int]:
    named = (re.fullmatch(r"curve-seed-([0-9]{1,9})\.jsonl", path.name) for path in folder.iterdir())
    return [int(match[1]) for match in named if match]


def _read(path: Path) -> list[_Report]:
    try:
        lines = path.read_bytes().splitlines()
    except OSError as error:
        raise CurveError(f"cannot read the learning curve {path}: {error.strerror}; train the seed again") from error
    reports = []
    for number, line in enumerate(lines, start=1):
        try:
            reports.append(_Report.model_validate_json(line))
        except ValidationError as error:
            raise CurveError(f"line {number} of {path} is no report: {first_problem(error)}") from error
    return reports


def _shares(table: Sequence[Sequence[_Report | None]], share: Callable[[_Report, str], float | None]) -> SharesRecord:
    def shares(outcome: str) -> Shares:
        return tuple(tuple(None if report is None else share(report, outcome) for report in curve) for curve in table)

    return SharesRecord(**{outcome: shares(outcome) for outcome in OUTCOMES})
