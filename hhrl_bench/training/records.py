"""How the episodes of a training ended, as a record: report by report, in training and in testing."""

import hashlib
from itertools import chain
from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from hhrl_bench.schema import Count, Name, Rate, Record
from hhrl_bench.statistics.intervals import FloatArray
from hhrl_bench.tasks.seeds import format_seeds

Shares = tuple[tuple[Rate | None, ...], ...]

_ROUNDING = 1e-9


class SharesRecord(Record):
    """The share of the episodes [seeds, reports] of each outcome; null: a seed has no episodes at a report."""

    success: Shares
    timeout: Shares
    not_stop: Shares
    collision: Shares

    def array(self, outcome: str) -> FloatArray:
        """Return the shares [seeds, reports] of an outcome; NaN for null."""
        return np.array(getattr(self, outcome), np.float64)


OUTCOMES = tuple(SharesRecord.model_fields)


class TrainingOutcomesRecord(Record):
    """How the episodes of a training ended, by seed, at ``env_steps`` [reports].

    ``training`` counts the episodes that ended since the report before, with the exploration of the time; ``testing``
    the validation episodes, played greedily at the report. A seed that failed has none from then on.
    """

    method: Name
    task: Name
    seeds: Annotated[tuple[Count, ...], Field(min_length=1)]
    env_steps: Annotated[tuple[Count, ...], Field(min_length=1)]
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
            tables: list[Shares] = [getattr(shares, outcome) for outcome in OUTCOMES]
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
