"""Estimates with 95% confidence intervals; every random draw comes from a generator that is passed in."""

import math
from typing import Literal, NamedTuple

import numpy as np

from hhrl_envs.arrays import Flags, Floats

CONFIDENCE = 0.95
BOOTSTRAP_SEED = 20200725
RESAMPLES = 9999
DRAWS_AT_ONCE = 10**5

IntervalKind = Literal["wilson-episodes", "bootstrap-episodes", "bootstrap-seeds", "none"]


class Estimate(NamedTuple):
    """A mean with the bounds of its confidence interval, the interquartile mean, and what n counts; NaN: unknown."""

    mean: float
    low: float
    high: float
    iqm: float
    n: int
    interval: IntervalKind


class Band(NamedTuple):
    """A mean [T] with the bounds of its confidence interval [T] at every point; NaN: unknown."""

    mean: Floats
    low: Floats
    high: Floats


def generator(key: str) -> np.random.Generator:
    """Return the generator of the draws for what has this key: the same whatever else is drawn."""
    return np.random.default_rng([BOOTSTRAP_SEED, *key.encode()])


def wilson(successes: int, n: int) -> Estimate:
    """Return the rate ``successes / n`` with its Wilson score interval (Wilson 1927)."""
    from scipy.stats import binomtest  # noqa: PLC0415

    bounds = binomtest(successes, n).proportion_ci(CONFIDENCE, method="wilson")
    return Estimate(successes / n, float(bounds.low), float(bounds.high), math.nan, n, "wilson-episodes")


def bootstrap_mean(values: Floats, rng: np.random.Generator, kind: IntervalKind) -> Estimate:
    """Return the mean of ``values`` [n] with its percentile bootstrap interval, and their interquartile mean.

    The bounds are NaN, and the kind "none", where n = 1 or a value is NaN.
    """
    from scipy.stats import bootstrap  # noqa: PLC0415

    n = len(values)
    mean, iqm = float(np.mean(values)), interquartile_mean(values)
    if n < 2 or math.isnan(mean):
        return Estimate(mean, math.nan, math.nan, iqm, n, "none")
    bounds = bootstrap(
        (values,),
        np.mean,
        n_resamples=RESAMPLES,
        batch=max(1, DRAWS_AT_ONCE // n),
        confidence_level=CONFIDENCE,
        method="percentile",
        rng=rng,
    ).confidence_interval
    return Estimate(mean, float(bounds.low), float(bounds.high), iqm, n, kind)


def bootstrap_band(curves: Floats, rng: np.random.Generator) -> Band:
    """Return the mean of ``curves`` [n, T] with its percentile bootstrap interval at every point.

    Whole curves are resampled; where a value is NaN, its curve does not count at that point. The bounds are NaN where
    n = 1, and so is everything at a point without values.
    """
    n, points = curves.shape
    known = np.isfinite(curves)
    band, some = Band(*np.full((3, points), np.nan)), known.any(axis=0)
    values, counted = np.where(known, curves, 0.0)[:, some], known[:, some]
    band.mean[some] = values.sum(axis=0) / counted.sum(axis=0)
    if n > 1:
        weights = rng.multinomial(n, np.full(n, 1.0 / n), size=RESAMPLES).astype(np.float64)
        with np.errstate(invalid="ignore"):
            means = weighted_sums(weights, values) / weighted_sums(weights, counted)
        tail = (1.0 - CONFIDENCE) / 2
        band.low[some], band.high[some] = np.nanquantile(means, (tail, 1.0 - tail), axis=0)
    return band


def weighted_sums(weights: Floats, values: Floats | Flags) -> Floats:
    """Return weights [R, n] times values [n, ...], [R, ...]; every sum is in the order of the n, on any processor."""
    shape = (len(weights), *(1,) * (values.ndim - 1))
    return sum(
        (column.reshape(shape) * value for column, value in zip(weights.T, values, strict=True)), np.zeros(shape)
    )


def interquartile_mean(values: Floats) -> float:
    """Return the mean of ``values`` [n] without the lowest and the highest quarter (Agarwal et al. 2021)."""
    from scipy.stats import trim_mean  # noqa: PLC0415

    return float(trim_mean(values, 0.25))
