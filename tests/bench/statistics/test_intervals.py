import math

import numpy as np
import pytest

from hhrl_bench.paper_table import CASES, TABLE_I
from hhrl_bench.statistics.intervals import bootstrap_band, bootstrap_mean, interquartile_mean, weighted_sums, wilson

# The Wilson bounds in percent of k successes in 100, computed by hand from Wilson's formula with z = 1.959964.
WILSON_OF_100 = {
    0: (0.0, 3.7), 7: (3.4, 13.7), 11: (6.3, 18.6), 14: (8.5, 22.1), 18: (11.7, 26.7), 31: (22.8, 40.6),
    69: (59.4, 77.2), 82: (73.3, 88.3), 86: (77.9, 91.5), 89: (81.4, 93.7), 93: (86.3, 96.6), 100: (96.3, 100.0),
}  # fmt: skip


@pytest.mark.parametrize(("successes", "bounds"), WILSON_OF_100.items())
def test_wilson_bounds_of_100_cases(successes: int, bounds: tuple[float, float]) -> None:
    estimate = wilson(successes, 100)
    assert (round(100 * estimate.low, 1), round(100 * estimate.high, 1)) == bounds
    assert estimate.mean == successes / 100
    assert (estimate.n, estimate.interval) == (100, "wilson-episodes")


def test_wilson_is_wilsons_formula() -> None:
    z, n, p = 1.959963984540054, 40, 0.3
    middle = (p + z * z / (2 * n)) / (1 + z * z / n)
    half = z / (1 + z * z / n) * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    estimate = wilson(12, n)
    assert estimate.low == pytest.approx(middle - half, rel=1e-12)
    assert estimate.high == pytest.approx(middle + half, rel=1e-12)


def test_the_bootstrap_interval_of_two_values_spans_them() -> None:
    estimate = bootstrap_mean(np.array([1.0, 3.0]), np.random.default_rng(0), "bootstrap-seeds")
    assert estimate == (2.0, 1.0, 3.0, 2.0, 2, "bootstrap-seeds")


def test_the_bootstrap_interval_of_many_values_is_the_normal_one() -> None:
    values = np.random.default_rng(1).normal(5.0, 2.0, 2000)
    estimate = bootstrap_mean(values, np.random.default_rng(0), "bootstrap-episodes")
    half = 1.96 * values.std() / math.sqrt(len(values))
    assert estimate.low == pytest.approx(estimate.mean - half, abs=0.05 * half)
    assert estimate.high == pytest.approx(estimate.mean + half, abs=0.05 * half)


def test_equal_generators_give_equal_intervals() -> None:
    values = np.arange(50.0)
    first, again, other = (bootstrap_mean(values, np.random.default_rng(s), "bootstrap-episodes") for s in (3, 3, 4))
    assert first == again
    assert first != other


def test_one_value_has_no_interval() -> None:
    estimate = bootstrap_mean(np.array([4.0]), np.random.default_rng(0), "bootstrap-episodes")
    assert (estimate.mean, estimate.n, estimate.interval) == (4.0, 1, "none")
    assert math.isnan(estimate.low)
    assert math.isnan(estimate.high)


def test_what_is_no_number_has_no_interval() -> None:
    estimate = bootstrap_mean(np.full(8, np.nan), np.random.default_rng(0), "bootstrap-episodes")
    assert math.isnan(estimate.mean)
    assert estimate.interval == "none"


def test_a_band_is_the_interval_of_the_mean_at_every_point() -> None:
    curves = np.random.default_rng(2).normal(size=(12, 3)) * [0.0, 1.0, 5.0] + [0.5, 1.0, 2.0]
    band = bootstrap_band(curves, np.random.default_rng(0))
    np.testing.assert_allclose(band.mean, curves.mean(axis=0), rtol=1e-14)
    assert (band.low[0], band.high[0]) == pytest.approx((0.5, 0.5))
    for point in (1, 2):
        alone = bootstrap_mean(curves[:, point], np.random.default_rng(0), "bootstrap-seeds")
        width = alone.high - alone.low
        assert band.low[point] == pytest.approx(alone.low, abs=0.03 * width)
        assert band.high[point] == pytest.approx(alone.high, abs=0.03 * width)


def test_curves_count_where_they_are_known() -> None:
    nan = math.nan
    band = bootstrap_band(np.array([[1.0, 0.0, nan], [3.0, nan, nan]]), np.random.default_rng(0))
    assert band.mean[:2].tolist() == [2.0, 0.0]
    assert (band.low[:2].tolist(), band.high[:2].tolist()) == ([1.0, 0.0], [3.0, 0.0])
    assert np.isnan([band.mean[2], band.low[2], band.high[2]]).all()


def test_one_curve_has_no_band() -> None:
    band = bootstrap_band(np.array([[0.0, 1.0]]), np.random.default_rng(0))
    assert band.mean.tolist() == [0.0, 1.0]
    assert np.isnan([band.low, band.high]).all()


def test_the_interquartile_mean_forgets_the_outer_quarters() -> None:
    assert interquartile_mean(np.array([-1000.0, 1.0, 3.0, 1000.0])) == 2.0
    assert interquartile_mean(np.array([0.0, 0.0, 4.0, 5.0, 6.0, 7.0, 99.0, 99.0])) == 5.5
    assert interquartile_mean(np.array([1.0, 2.0, 6.0])) == 3.0


def test_every_case_of_table_i_ended_somehow() -> None:
    assert [row.collision + row.not_stop + row.timeout + row.success for row in TABLE_I] == [CASES] * 5


def test_weighted_sums_are_matrix_products_in_the_order_of_the_terms() -> None:
    rng = np.random.default_rng(0)
    weights, values, curves = rng.normal(size=(50, 9)), rng.normal(size=9), rng.normal(size=(9, 4))
    np.testing.assert_allclose(weighted_sums(weights, values), weights @ values, rtol=1e-12)
    np.testing.assert_allclose(weighted_sums(weights, curves), weights @ curves, rtol=1e-12)
    large = np.array([1.0, 1e16, -1e16])
    assert weighted_sums(np.ones((1, 3)), large).tolist() == [0.0]
    assert weighted_sums(np.ones((1, 3)), large[::-1]).tolist() == [1.0]
