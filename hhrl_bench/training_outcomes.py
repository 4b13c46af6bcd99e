"""How the episodes of a training ended, report by report: those it learned from, and those of its validation."""

import json
import re
from collections.abc import Callable, Mapping, Sequence
from math import nan
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pydantic import BaseModel, ValidationError

from hhrl_bench.analysis_records import OutcomeName
from hhrl_bench.errors import CurveError
from hhrl_bench.records import Count, Rate, first_problem
from hhrl_bench.statistics import FloatArray

OUTCOMES: tuple[OutcomeName, ...] = ("success", "timeout", "not_stop", "collision")


class TrainingOutcomes(NamedTuple):
    """The share of the episodes [seeds, reports] of each outcome, at ``env_steps`` [reports]; NaN: a seed has none.

    ``training`` counts the episodes that ended since the report before, with the exploration of the time; ``testing``
    the validation episodes, played greedily at the report. A seed that failed has none from then on.
    """

    method: str
    task: str
    seeds: tuple[int, ...]
    env_steps: FloatArray
    training: Mapping[OutcomeName, FloatArray]
    testing: Mapping[OutcomeName, FloatArray]

    @property
    def stopped(self) -> int:
        """How many seeds have no validation at the last report: they failed, or have not come so far."""
        return int(np.isnan(self.testing["success"][:, -1]).sum())


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

    def trained(self, outcome: OutcomeName) -> float:
        total = sum(self.episodes.values())
        return self.episodes.get(outcome, 0) / total if total else nan

    def tested(self, outcome: OutcomeName) -> float:
        return getattr(self.validation, outcome, nan)


def read_outcomes(folder: Path) -> TrainingOutcomes:
    """Return the outcomes of a run directory, whose training may be under way.

    Raises:
        CurveError: if it holds no curves, or ones that are damaged or have different reports.
    """
    method, task = _trained(folder)
    curves = {seed: _read(path) for seed, path in sorted(_paths(folder).items())}
    env_steps = max(([report.env_steps for report in curve] for curve in curves.values()), key=len, default=[])
    if not env_steps:
        raise CurveError(f"{folder} holds no learning curves; name a folder that hhrl-bench train has filled")
    for seed, curve in curves.items():
        if [report.env_steps for report in curve] != env_steps[: len(curve)]:
            raise CurveError(
                f"the reports of seed {seed} in {folder} are at other env steps than those of another seed"
            )
    table = [[*curve, *[None] * (len(env_steps) - len(curve))] for curve in curves.values()]
    return TrainingOutcomes(
        method=method,
        task=task,
        seeds=tuple(curves),
        env_steps=np.array(env_steps, np.float64),
        training=_shares(table, _Report.trained),
        testing=_shares(table, _Report.tested),
    )


def _trained(folder: Path) -> tuple[str, str]:
    """Return the method and the task of a run directory."""
    try:
        config = json.loads((folder / "config.json").read_text(encoding="utf-8"))
        return str(config["method"]["id"]), str(config["task"])
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise CurveError(
            f"{folder} has no config.json to read; name a folder that hhrl-bench train has filled"
        ) from error


def _paths(folder: Path) -> dict[int, Path]:
    named = ((re.fullmatch(r"curve-seed-([0-9]+)\.jsonl", path.name), path) for path in folder.iterdir())
    return {int(match[1]): path for match, path in named if match}


def _read(path: Path) -> list[_Report]:
    reports = []
    for number, line in enumerate(path.read_bytes().splitlines(), start=1):
        try:
            reports.append(_Report.model_validate_json(line))
        except ValidationError as error:
            raise CurveError(f"line {number} of {path} is no report: {first_problem(error)}") from error
    return reports


def _shares(
    table: Sequence[Sequence[_Report | None]], share: Callable[[_Report, OutcomeName], float]
) -> dict[OutcomeName, FloatArray]:
    return {
        name: np.array([[nan if report is None else share(report, name) for report in curve] for curve in table])
        for name in OUTCOMES
    }
