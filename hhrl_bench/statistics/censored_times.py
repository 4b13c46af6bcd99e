"""Times censored at a budget, their median, and the ratio of the medians of two samples of them.

A censored time is infinite here: all that is known is that it lies beyond the budget. A median of such times, and a
ratio of two, is known within bounds alone. The bounds are kept through the bootstrap, the low ends of its resamples for
the low end of the interval and the high ends for the high one, so that whatever the censored times really are, the
median or ratio and its interval lie within what is said: none is made to look better by ending a training early.
"""

from typing import NamedTuple

import numpy as np

from hhrl_bench.statistics.intervals import CONFIDENCE, RESAMPLES
from hhrl_envs.arrays import Floats


class Bounded(NamedTuple):
    """What lies in [at_least, at_most], one number where it is known, and its interval; inf: unbounded, NaN: none."""

    at_least: float
    at_most: float
    low: float
    high: float


def median(times: Floats, budget: float, rng: np.random.Generator) -> Bounded:
    """Return the median of ``times`` [n] censored at ``budget``; a percentile bootstrap, so none where n is 1."""
    at_least, at_most = _medians(times, budget)
    if len(times) < 2:
        return Bounded(float(at_least), float(at_most), np.nan, np.nan)
    return Bounded(float(at_least), float(at_most), *_interval(*_medians(_resampled(times, rng), budget)))


def ratio_of_medians(a: Floats, b: Floats, budget: float, rng: np.random.Generator) -> Bounded:
    """Return the median of times ``a`` [n] over that of ``b`` [m], both censored at ``budget``.

    The interval is a percentile bootstrap that resamples the two independently; where n or m is 1 there is none. A
    median ``b`` of 0 bounds nothing: what needs no time cannot be taken as the measure.
    """
    at_least, at_most = _bounds(a, b, budget)
    if min(len(a), len(b)) < 2:
        return Bounded(float(at_least), float(at_most), np.nan, np.nan)
    resampled = _bounds(_resampled(a, rng), _resampled(b, rng), budget)
    return Bounded(float(at_least), float(at_most), *_interval(*resampled))


def _resampled(times: Floats, rng: np.random.Generator) -> Floats:
    return times[rng.integers(len(times), size=(RESAMPLES, len(times)))]


def _bounds(a: Floats, b: Floats, budget: float) -> tuple[Floats, Floats]:
    """Return the least and the greatest ratio of the medians of ``a`` [..., n] and ``b`` [..., m] that may be."""
    (least_a, most_a), (least_b, most_b) = _medians(a, budget), _medians(b, budget)
    return _over(least_a, most_b, otherwise=0.0), _over(most_a, least_b, otherwise=np.inf)


def _medians(times: Floats, budget: float) -> tuple[Floats, Floats]:
    """Return the least and the greatest median of ``times`` [..., n] that may be, [...] each."""
    return np.median(np.minimum(times, budget), axis=-1), np.median(times, axis=-1)


def _interval(lows: Floats, highs: Floats) -> tuple[float, float]:
    tail = (1.0 - CONFIDENCE) / 2
    low, high = np.quantile(lows, tail, method="lower"), np.quantile(highs, 1.0 - tail, method="higher")
    return float(low), float(high)


def _over(a: Floats, b: Floats, otherwise: float) -> Floats:
    ratio = np.full(np.shape(a), otherwise)
    np.divide(a, b, out=ratio, where=b > 0.0)
    return ratio
