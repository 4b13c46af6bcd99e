"""Summaries: what the runs of one agent on one task come to, each metric bootstrapped from a generator of its own."""

from collections.abc import Mapping, Sequence

import numpy as np

from hhrl_bench.episodes import EpisodeRecords
from hhrl_bench.metrics import SCORED, FloatArray, Metric, mean
from hhrl_bench.records import MetricRecord, MetricsRecord, RunMetricsRecord, metric_record
from hhrl_bench.statistics import Estimate, IntervalKind, bootstrap_mean, wilson

BOOTSTRAP_SEED = 20200725


def generator(key: str) -> np.random.Generator:
    """Return the generator of the draws for what has this key: the same whatever else is drawn."""
    return np.random.default_rng([BOOTSTRAP_SEED, *key.encode()])


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
