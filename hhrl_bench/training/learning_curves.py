"""Learning curves: how the episodes of a training ended, as a record of its run directory, and success curves."""

import hashlib
import json
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import chain, pairwise
from pathlib import Path
from typing import Annotated, Self

import numpy as np
from pydantic import BaseModel, Field, ValidationError, model_validator

from hhrl_bench.errors import CurveError
from hhrl_bench.schema import FIRST, MAX_REPORTS, MAX_SEEDS, Count, Name, Rate, Record, first_problem
from hhrl_bench.tasks.seeds import format_seeds
from hhrl_bench.training.run_directory import RunDirectory
from hhrl_envs.arrays import Floats

SeedShares = Annotated[tuple[Annotated[tuple[Rate | None, ...], FIRST], ...], FIRST]

_ROUNDING = 1e-9


class SharesRecord(Record):
    """The share of the episodes [seeds, reports] of each outcome; null: a seed has no episodes at a report."""

    success: SeedShares
    timeout: SeedShares
    not_stop: SeedShares
    collision: SeedShares

    def array(self, outcome: str) -> Floats:
        """Return the shares [seeds, reports] of an outcome; NaN for null."""
        return np.array(getattr(self, outcome), np.float64)


TRAINING_OUTCOMES = tuple(SharesRecord.model_fields)


class TrainingOutcomesRecord(Record):
    """How the episodes of a training ended, by seed, at ``env_steps`` [reports].

    ``training`` counts the episodes that ended since the report before, with the exploration of the time; ``testing``
    the validation episodes, played greedily at the report. A seed that failed has none from then on.
    """

    method: Name
    task: Name
    seeds: Annotated[tuple[Count, ...], FIRST, Field(min_length=1, max_length=MAX_SEEDS)]
    env_steps: Annotated[tuple[Count, ...], FIRST, Field(min_length=1, max_length=MAX_REPORTS)]
    training: SharesRecord
    testing: SharesRecord

    def digest(self) -> str:
        """Return the sha256, in hex, of the record as compact JSON."""
        return hashlib.sha256(self.model_dump_json().encode()).hexdigest()

    @property
    def runs(self) -> str:
        """Its seeds, and how many of them have no validation at the last report: failed, or not so far yet."""
        stopped = int(np.isnan(self.testing.array("success")[:, -1]).sum())
        return f"seeds {format_seeds(self.seeds)}" + (f", {stopped} not to the end" if stopped else "")

    @model_validator(mode="after")
    def _is_consistent(self) -> Self:
        _require(_ascend(self.seeds), "its seeds ascend")
        _require(_ascend(self.env_steps), "its env steps ascend")
        shape = [len(self.env_steps)] * len(self.seeds)
        for shares in (self.training, self.testing):
            tables: list[SeedShares] = [getattr(shares, outcome) for outcome in TRAINING_OUTCOMES]
            fits = all([*map(len, table)] == shape for table in tables)
            _require(fits, "every outcome has one share a seed and report")
            together = zip(*map(chain.from_iterable, tables), strict=True)
            _require(all(map(_is_whole, together)), "shares are null together, and add up to at most 1")
        return self


def _ascend(numbers: tuple[int, ...]) -> bool:
    return list(numbers) == sorted(set(numbers))


def _is_whole(shares: tuple[float | None, ...]) -> bool:
    """Return whether the shares of all outcomes, of one seed at one report, can be."""
    known = [share for share in shares if share is not None]
    return not known or (len(known) == len(shares) and sum(known) <= 1.0 + _ROUNDING)


def _require(holds: bool, rule: str) -> None:
    if not holds:
        raise ValueError(f"the record of a training is such that {rule}; this one is not")


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
    def shares(outcome: str) -> SeedShares:
        return tuple(tuple(None if report is None else share(report, outcome) for report in curve) for curve in table)

    return SharesRecord(**{outcome: shares(outcome) for outcome in TRAINING_OUTCOMES})


THRESHOLD = 0.93
"""The success rate of Hybrid HRL in Table I of Qiao et al. (2020)."""


@dataclass(frozen=True, slots=True)
class Curve:
    """One seed's validation success rates [T] at ``env_steps`` [T], from step 0 to the budget, which is the last one.

    Raises:
        CurveError: if there is no report, the steps do not ascend from 0, or a success is no rate.
    """

    env_steps: Annotated[tuple[int, ...], FIRST]
    success: Annotated[tuple[float, ...], FIRST]

    def __post_init__(self) -> None:
        """Reject what is no curve."""
        steps, success = self.env_steps, self.success
        if not steps or len(steps) != len(success):
            raise CurveError(f"a curve has {len(steps)} steps and {len(success)} successes; write one success a step")
        if steps[0] != 0 or any(after <= before for before, after in pairwise(steps)):
            raise CurveError(f"the env steps of a curve are {listed(steps)}; write ascending ones that begin with 0")
        if not all(0.0 <= rate <= 1.0 for rate in success):
            raise CurveError(f"the successes of a curve are {listed(success)}; write rates of 0 to 1")


def time_to_threshold(curve: Curve) -> int | None:
    """Return the env steps of the first report with a success of at least THRESHOLD; None: censored, never reached.

    It is as coarse as the reports, and a lucky report counts: compare it between curves with the same reports alone.
    """
    reached = (steps for steps, rate in zip(curve.env_steps, curve.success, strict=True) if rate >= THRESHOLD)
    return next(reached, None)


def area(curve: Curve) -> float:
    """Return the area under the curve by the trapezoid rule, over the budget: the mean success, in [0, 1].

    That of a single report is its success.
    """
    if len(curve.success) == 1:
        return curve.success[0]
    steps, success = np.array(curve.env_steps), np.array(curve.success)
    return float(np.sum(np.diff(steps) * (success[1:] + success[:-1])) / (2 * steps[-1]))


def listed(values: tuple[float, ...]) -> str:
    """Return the values, or the first and last ones of many, for a message."""
    words = [f"{value:.12g}" for value in values]
    return ", ".join(words if len(words) <= 6 else [*words[:4], "...", words[-1]])
