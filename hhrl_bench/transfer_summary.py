"""What the curves of all seeds come to: each metric by seed and its interval over the seeds, as records."""

from collections.abc import Sequence
from math import inf, isfinite

import numpy as np

from hhrl_bench.censored import ratio_of_medians
from hhrl_bench.statistics import FloatArray, bootstrap_mean
from hhrl_bench.transfer_metrics import (
    Curve,
    asymptotic_gain,
    forward_transfer,
    jumpstart,
    time_to_threshold,
    transfer_ratio,
)
from hhrl_bench.transfer_records import ComparisonRecord, SeedsMetricRecord, StepsRatioRecord, StepsRecord


def comparison(a: Sequence[Curve], b: Sequence[Curve], rng: np.random.Generator) -> ComparisonRecord:
    """Return what the curves ``a`` are worth over the curves ``b``, seed by seed."""
    pairs = list(zip(a, b, strict=True))
    return ComparisonRecord(
        jumpstart=summary([jumpstart(*pair) for pair in pairs], rng),
        asymptotic_gain=summary([asymptotic_gain(*pair) for pair in pairs], rng),
        transfer_ratio=summary([transfer_ratio(*pair) for pair in pairs], rng),
        forward_transfer=summary([forward_transfer(*pair) for pair in pairs], rng),
        steps_ratio=_steps_ratio(a, b, rng),
    )


def summary(values: Sequence[float | None], rng: np.random.Generator) -> SeedsMetricRecord:
    """Return the values of all seeds, and the mean of those that are defined with its bootstrap interval."""
    defined = np.array([value for value in values if value is not None])
    if not defined.size:
        return SeedsMetricRecord(per_seed=tuple(values), mean=None, low=None, high=None, n=0)
    mean, low, high, _, n, _ = bootstrap_mean(defined, rng, "bootstrap-seeds")
    return SeedsMetricRecord(per_seed=tuple(values), mean=mean, low=_finite(low), high=_finite(high), n=n)


def steps_to_threshold(curves: Sequence[Curve]) -> StepsRecord:
    """Return every seed's time to threshold, and their median with the censored ones beyond the budget."""
    times = tuple(time_to_threshold(curve) for curve in curves)
    reached = sum(time is not None for time in times)
    return StepsRecord(per_seed=times, median=_finite(float(np.median(censored_times(curves)))), reached=reached)


def censored_times(curves: Sequence[Curve]) -> FloatArray:
    """Return every curve's time to threshold [n]; infinite: never reached."""
    times = (time_to_threshold(curve) for curve in curves)
    return np.array([inf if time is None else time for time in times], np.float64)


def _steps_ratio(a: Sequence[Curve], b: Sequence[Curve], rng: np.random.Generator) -> StepsRatioRecord:
    ratio = ratio_of_medians(censored_times(a), censored_times(b), b[0].env_steps[-1], rng)
    at_most, low, high = map(_finite, (ratio.at_most, ratio.low, ratio.high))
    return StepsRatioRecord(at_least=ratio.at_least, at_most=at_most, low=low, high=high)


def _finite(value: float) -> float | None:
    return value if isfinite(value) else None
