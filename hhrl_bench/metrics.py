"""The columns of Table I, the task's own reward, and how severe it got, as functions of episode records."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hhrl_bench.episodes import EpisodeRecords
from hhrl_envs import Outcome

FloatArray = NDArray[np.float64]


class Metric(NamedTuple):
    """A number of every episode: ``values`` maps records of N episodes to float64 [N]; a rate is one of 0 and 1.

    It is NaN in the episodes that do not have it.
    """

    key: str
    is_rate: bool
    values: Callable[[EpisodeRecords], FloatArray]


def _field(key: str) -> Metric:
    return Metric(key, False, lambda records: np.asarray(getattr(records, key), np.float64))


def _rate(key: str, outcome: Outcome) -> Metric:
    return Metric(key, True, lambda records: np.asarray(records.outcome == outcome, np.float64))


METRICS = (
    _field("return_task"),
    _field("return_option"),
    _field("return_action"),
    _field("steps"),
    _field("unsmooth"),
    _field("unsafe"),
    _rate("collision", Outcome.COLLISION),
    _rate("not_stop", Outcome.NOT_STOP),
    _rate("timeout", Outcome.TIMEOUT),
    _rate("success", Outcome.SUCCESS),
)
"""What training is watched by."""

SCORED = (*METRICS, _field("impact_speed"), _field("smallest_gap"), _field("smallest_ttc"))
"""What agents are scored by."""


def means(records: EpisodeRecords, metrics: Sequence[Metric] = METRICS) -> dict[str, float]:
    """Return the mean of every metric over the episodes that have it, NaN where none has."""
    return {metric.key: mean(metric.values(records)) for metric in metrics}


def mean(values: FloatArray) -> float:
    """Return the mean of the values that are not NaN; NaN if all are."""
    known = values[~np.isnan(values)]
    return float(np.mean(known)) if known.size else math.nan


def finite(numbers: Mapping[str, float]) -> dict[str, float | None]:
    """Return the numbers with None, which JSON can say, in place of NaN and infinities."""
    return {key: value if math.isfinite(value) else None for key, value in numbers.items()}
