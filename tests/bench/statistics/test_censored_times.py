"""Ratios of censored medians: known ones, bounded ones, and that the bounds hold whatever the censored times are."""

from math import inf, isnan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hhrl_bench.statistics.censored_times import Bounded, median, ratio_of_medians

BUDGET = 100.0


def ratio(a: list[float], b: list[float], seed: int = 0) -> Bounded:
    return ratio_of_medians(np.array(a), np.array(b), BUDGET, np.random.default_rng(seed))


@pytest.mark.parametrize(
    ("a", "b", "wanted"),
    [
        ([20.0] * 3, [40.0] * 5, (0.5, 0.5, 0.5, 0.5)),
        ([20.0] * 3, [inf] * 3, (0.0, 0.2, 0.0, 0.2)),
        ([inf] * 3, [40.0] * 3, (2.5, inf, 2.5, inf)),
        ([inf] * 3, [inf] * 3, (0.0, inf, 0.0, inf)),
        ([0.0] * 3, [40.0] * 3, (0.0, 0.0, 0.0, 0.0)),
        ([0.0] * 3, [inf] * 3, (0.0, 0.0, 0.0, 0.0)),
        ([20.0] * 3, [0.0] * 3, (0.0, inf, 0.0, inf)),
        ([0.0] * 3, [0.0] * 3, (0.0, inf, 0.0, inf)),
    ],
    ids=["both", "b-never", "a-never", "neither", "a-at-once", "a-at-once-b-never", "b-at-once", "both-at-once"],
)
def test_ratios_of_constant_times(a: list[float], b: list[float], wanted: tuple[float, ...]) -> None:
    assert ratio(a, b) == wanted


def test_half_of_an_even_number_censored_bounds_the_median_between_time_and_budget() -> None:
    known = ratio([20.0, inf], [50.0, 50.0])
    assert (known.at_least, known.at_most) == (60.0 / 50.0, inf)
    known = ratio([20.0, 20.0], [50.0, inf])
    assert (known.at_least, known.at_most) == (0.0, 20.0 / 75.0)


def test_the_interval_of_two_values_each_spans_their_ratios() -> None:
    known = ratio([10.0, 30.0], [40.0, 80.0])
    assert known == (20.0 / 60.0, 20.0 / 60.0, 10.0 / 80.0, 30.0 / 40.0)


def test_one_time_has_a_ratio_and_no_interval() -> None:
    known = ratio([10.0], [40.0, 40.0])
    assert (known.at_least, known.at_most) == (0.25, 0.25)
    assert isnan(known.low)
    assert isnan(known.high)


def test_few_censored_resamples_leave_the_upper_bound_finite_and_many_do_not() -> None:
    often, seldom = [30.0] * 6 + [inf] * 3, [30.0] * 9 + [inf]
    assert ratio(seldom, [60.0] * 9).high == 0.5
    assert ratio(often, [60.0] * 9).high == inf
    assert ratio(often, [60.0] * 9).at_most == 0.5


@pytest.mark.parametrize(
    ("times", "wanted"),
    [
        ([20.0] * 3, (20.0, 20.0, 20.0, 20.0)),
        ([inf] * 3, (100.0, inf, 100.0, inf)),
        ([20.0, 60.0], (40.0, 40.0, 20.0, 60.0)),
        ([20.0, inf], (60.0, inf, 20.0, inf)),
        ([20.0] * 9 + [inf], (20.0, 20.0, 20.0, 20.0)),
    ],
    ids=["known", "never", "two", "half", "few-censored"],
)
def test_medians(times: list[float], wanted: tuple[float, ...]) -> None:
    assert median(np.array(times), BUDGET, np.random.default_rng(0)) == wanted


def test_the_median_of_one_time_has_no_interval() -> None:
    known = median(np.array([20.0]), BUDGET, np.random.default_rng(0))
    assert (known.at_least, known.at_most) == (20.0, 20.0)
    assert isnan(known.low)
    assert isnan(known.high)


def test_equal_generators_give_equal_intervals() -> None:
    a, b = [*np.arange(10.0, 90.0, 7.0)], [*np.arange(15.0, 99.0, 9.0)]
    assert ratio(a, b) == ratio(a, b)
    assert ratio(a, b) != ratio(a, b, seed=1)


times = st.lists(st.floats(1.0, 1000.0), min_size=2, max_size=5)


@settings(max_examples=40, deadline=None)
@given(times, times)
def test_the_bounds_hold_whatever_the_censored_times_really_are(a: list[float], b: list[float]) -> None:
    def seen(times: list[float]) -> list[float]:
        return [time if time <= BUDGET else inf for time in times]

    said, true = ratio(seen(a), seen(b)), ratio_of_medians(np.array(a), np.array(b), inf, np.random.default_rng(0))
    assert true.at_least == true.at_most
    assert said.at_least <= true.at_least <= said.at_most
    assert said.low <= true.low <= true.high <= said.high
