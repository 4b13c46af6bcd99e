"""The columns of Table I, the task's own reward, and how severe it got, as functions of episode records."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hhrl_bench.evaluation.episodes import EpisodeRecords
from hhrl_bench.evaluation.records import MetricRecord, MetricsRecord, RunMetricsRecord, metric_record
from hhrl_bench.statistics.intervals import Estimate, IntervalKind, bootstrap_mean, generator, wilson
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


def summarise(played: Sequence[EpisodeRecords]) -> MetricsRecord:
    """Return every metric with its interval: over training seeds if there are several, else over episodes."""
    if len(played) > 1:
        runs = [{metric.key: mean(metric.values(records)) for metric in SCORED} for records in played]
        return _record({metric.key: _over_runs(metric, [run[metric.key] for run in runs]) for metric in SCORED})
    return _record({metric.key: over_episodes(metric, metric.values(played[0])) for metric in SCORED})


def summarise_runs(runs: Sequence[RunMetricsRecord]) -> MetricsRecord:
    """Return what ``summarise`` does for several runs, from their means alone."""
    known = {metric: [getattr(run, metric.key) for run in runs] for metric in SCORED}
    return _record({metric.key: _over_runs(metric, values) for metric, values in known.items()})


def over_episodes(metric: Metric, values: FloatArray) -> MetricRecord:
    """Return a metric of a single run from its values [episodes]."""
    if metric.is_rate:
        return metric_record(wilson(int(values.sum()), len(values)))
    return metric_record(_bootstrap(metric, values, "bootstrap-episodes"))


def _over_runs(metric: Metric, means: Sequence[float | None]) -> MetricRecord:
    return metric_record(_bootstrap(metric, np.array(means, np.float64), "bootstrap-seeds"))


def _bootstrap(metric: Metric, values: FloatArray, kind: IntervalKind) -> Estimate:
    """Return the estimate of the values that are known; where none is, of nothing."""
    known = values[~np.isnan(values)]
    return bootstrap_mean(known if known.size else values, generator(metric.key), kind)


def _record(metrics: Mapping[str, MetricRecord]) -> MetricsRecord:
    return MetricsRecord(**metrics)
