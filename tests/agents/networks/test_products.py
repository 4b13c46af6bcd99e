"""Products of matrices: every sum in the order of its terms, whatever the shapes, and nothing written beside them."""

from typing import Any, cast

import numpy as np
import pytest
from numba import njit

from hhrl_agents.networks import products as kernels
from hhrl_agents.networks.arithmetic import matrix
from hhrl_envs.arrays import Floats32

compiled = cast(Any, njit)


@compiled  # type: ignore[untyped-decorator]
def products(x: Floats32, w: Floats32, out: Floats32) -> None:
    kernels.add_product(x, w, out)


@compiled  # type: ignore[untyped-decorator]
def outer_products(x: Floats32, g: Floats32, out: Floats32) -> None:
    kernels.write_outer(x, g, out)


def steps_of(x: Floats32, w: Floats32, out: Floats32) -> Floats32:
    """Return out + x w, every sum by one fused product after the other.

    A float64 holds the product of two float32 exactly; the sum is rounded twice, which differs from once only if the
    first rounding meets the middle of two float32: not with the small whole numbers and halves of these tests.
    """
    out = out.copy()
    for term in range(x.shape[1]):
        out = (x[:, term, None].astype(np.float64) * w[term] + out).astype(np.float32)
    return out


@pytest.mark.parametrize("rows", [1, 3, 4, 6, 9])
@pytest.mark.parametrize("terms", [1, 4, 7])
@pytest.mark.parametrize("width", [1, 2, 8, 16, 33, 64, 83])
def test_sums_are_in_the_order_of_their_terms(rows: int, terms: int, width: int) -> None:
    rng = np.random.default_rng(rows * 100 + terms * 10 + width)
    x, w, out = (rng.normal(size=shape).astype(np.float32) for shape in ((rows, terms), (terms, width), (rows, width)))
    expected = steps_of(x, w, out)
    products(x, w, out)
    np.testing.assert_allclose(out, expected, rtol=1e-6, atol=1e-6)
    alone = np.empty_like(out)
    for row in range(rows):
        start = np.zeros((1, width), np.float32)
        products(x[row : row + 1], w, start)
        alone[row] = start[0]
    together = np.zeros_like(out)
    products(x, w, together)
    assert together.tobytes() == alone.tobytes()
    gradient = np.empty((terms, width), np.float32)
    outer_products(x, out, gradient)
    np.testing.assert_allclose(gradient, x.T @ out, rtol=1e-4, atol=1e-5)
    one_term = np.empty((1, width), np.float32)
    outer_products(np.ascontiguousarray(x[:, -1:]), out, one_term)
    assert one_term.tobytes() == gradient[-1:].tobytes()


@compiled  # type: ignore[untyped-decorator]
def product_within(x: Floats32, w: Floats32, numbers: Floats32, first: int, rows: int) -> None:
    kernels.add_product(x, w, matrix(numbers, first, rows, w.shape[1]))


@pytest.mark.parametrize("rows", [1, 8, 9])
@pytest.mark.parametrize("width", [1, 15, 16, 17, 64, 67])
def test_a_product_leaves_what_lies_beside_it_alone(rows: int, width: int) -> None:
    x, w = np.ones((rows, 3), np.float32), np.ones((3, width), np.float32)
    first, numbers = 7, np.zeros(7 + rows * width + 70, np.float32)
    product_within(x, w, numbers, first, rows)
    assert (numbers[first : first + rows * width] == 3.0).all()
    assert not numbers[:first].any()
    assert not numbers[first + rows * width :].any()
