"""The columns of Table I, and the task's own reward, as functions of episode records."""

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hhrl_bench.episodes import EpisodeRecords
from hhrl_envs import Outcome

FloatArray = NDArray[np.float64]


class Metric(NamedTuple):
    """A number of every episode: ``values`` maps records of N episodes to float64 [N]; a rate is one of 0 and 1."""

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


def means(records: EpisodeRecords) -> dict[str, float]:
    """Return the mean of every metric over the episodes, NaN where the agent has none."""
    return {metric.key: float(np.mean(metric.values(records))) for metric in METRICS}


def finite(numbers: Mapping[str, float]) -> dict[str, float | None]:
    """Return the numbers with None, which JSON can say, in place of NaN and infinities."""
    return {key: value if math.isfinite(value) else None for key, value in numbers.items()}
