"""Our exp, log and power beside those of the library of mathematics."""

import math
from collections.abc import Callable
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

from hhrl_agents.networks import arithmetic
from hhrl_envs.arrays import Floats

ULPS = 4
compiled = cast(Any, njit)


def on_array(function: Callable[[float], float]) -> Callable[[Floats], Floats]:
    """Return a function of numbers, which is a part of kernels, as one of arrays."""

    @compiled  # type: ignore[untyped-decorator]
    def apply(numbers: Floats) -> Floats:
        results = np.empty_like(numbers)
        for index in range(numbers.size):
            results[index] = function(numbers[index])
        return results

    return apply  # type: ignore[no-any-return]


EXP, LOG = on_array(arithmetic.exp), on_array(arithmetic.log)


@compiled  # type: ignore[untyped-decorator]
def power(x: float, exponent: float) -> float:
    return arithmetic.power(x, exponent)


def near(found: float, expected: float, ulps: float = ULPS) -> bool:
    return abs(found - expected) <= ulps * math.ulp(expected)


@settings(deadline=None, max_examples=500)
@given(st.floats(-700.0, 700.0))
def test_exp_is_within_some_units_of_the_last_place(x: float) -> None:
    assert near(float(EXP(np.array([x]))[0]), math.exp(x))


@settings(deadline=None, max_examples=500)
@given(st.floats(2.3e-308, 1.7e308))
def test_log_is_within_some_units_of_the_last_place(x: float) -> None:
    assert near(float(LOG(np.array([x]))[0]), math.log(x))


@settings(deadline=None, max_examples=500)
@given(st.floats(1e-6, 1e6), st.floats(-2.0, 2.0))
def test_power_is_within_what_the_rounding_of_its_exponent_allows(x: float, exponent: float) -> None:
    # An error of half a unit in the logarithm, and one in its product, grow with the size of the exponent of e.
    ulps = ULPS * (1 + abs(exponent * math.log(x)))
    assert near(power(x, exponent), x**exponent, ulps)


@settings(deadline=None, max_examples=300)
@given(st.floats(1e-3, 1.0), st.floats(0.0, 1.0))
def test_power_of_a_priority_is_within_some_units_of_the_last_place(x: float, exponent: float) -> None:
    assert near(power(x, exponent), x**exponent, 4 * ULPS)


def test_edges() -> None:
    found = EXP(np.array([0.0, -0.0, 700.0, 1e300, np.inf, -700.0, -1e300, -np.inf]))
    assert found[0] == found[1] == 1.0
    assert found[2] == found[3] == found[4]
    assert found[5] == found[6] == found[7] > 0.0
    assert LOG(np.array([1.0]))[0] == 0.0
    assert power(0.0, 0.6) == 0.0
    assert power(1.0, 0.6) == 1.0
    assert power(7.0, 0.0) == 1.0


@pytest.mark.parametrize("edge", [math.log(2.0) / 2, -math.log(2.0) / 2, math.log(2.0) * 3.5, -20.0, 1e-300])
def test_exp_never_falls_where_its_range_is_reduced(edge: float) -> None:
    near_by = [edge]
    for _ in range(200):
        near_by = [math.nextafter(near_by[0], -math.inf), *near_by, math.nextafter(near_by[-1], math.inf)]
    values = EXP(np.array(near_by))
    assert (np.diff(values) >= -ULPS * np.spacing(values[1:])).all()
    assert values[-1] >= values[0]


@pytest.mark.parametrize("edge", [1.0, math.sqrt(2.0), 2.0, 0.5, math.sqrt(0.5)])
def test_log_rises_where_its_range_is_reduced(edge: float) -> None:
    below, above = LOG(np.array([edge * (1 - 1e-12), edge * (1 + 1e-12)]))
    assert below < above
