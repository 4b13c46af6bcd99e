"""Arithmetic that gives the same bits on every processor: fused products in a fixed order, and exp, log and pow.

IEEE 754 fixes the results of + - * / sqrt and fma. What is built from them here, in an order that the source fixes,
depends on no library of mathematics, vector width or number of threads: vectors run along outputs, never along a sum.
"""

from typing import TYPE_CHECKING, Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from hhrl_envs.arrays import Floats32
from hhrl_envs.simulation.engine.compilation import inner

ZERO, ONE = np.float32(0.0), np.float32(1.0)

if TYPE_CHECKING:

    def fma(a: Any, b: Any, c: Any) -> Any:
        """Return a b + c, rounded once; all float32 or all float64."""

    def _from_bits(bits: Any) -> float: ...

    def _to_bits(number: float) -> int: ...

else:

    @intrinsic
    def fma(_: Any, a: Any, b: Any, c: Any) -> Any:
        """Return a b + c, rounded once; all float32 or all float64."""
        if (a, b, c) not in {(types.float32,) * 3, (types.float64,) * 3}:
            return None
        return a(a, b, c), lambda _context, builder, _signature, values: builder.fma(*values)

    @intrinsic
    def _from_bits(_: Any, bits: Any) -> Any:
        kind = ir.DoubleType()
        return types.float64(bits), lambda _context, builder, _signature, values: builder.bitcast(values[0], kind)

    @intrinsic
    def _to_bits(_: Any, number: Any) -> Any:
        kind = ir.IntType(64)
        return types.int64(number), lambda _context, builder, _signature, values: builder.bitcast(values[0], kind)


_LOG2_E = 1.4426950408889634
_LN2_HIGH, _LN2_LOW = 0.6931471803691238, 1.9082149292705877e-10
_SQRT2 = 1.4142135623730951
_FRACTION, _BIAS = (1 << 52) - 1, 1023
_EXP = tuple(1.0 / float(np.prod(np.arange(1.0, degree + 1.0))) for degree in range(13, -1, -1))
_LOG = tuple(1.0 / degree for degree in range(21, 0, -2))
_LARGEST = 700.0


@inner
def exp(x: float) -> float:
    """Return e^x within some units of the last place; x beyond +-700 counts as +-700."""
    x = min(max(x, -_LARGEST), _LARGEST)
    power = np.floor(fma(x, _LOG2_E, 0.5))
    rest = fma(power, -_LN2_LOW, fma(power, -_LN2_HIGH, x))
    series = 0.0
    for coefficient in _EXP:
        series = fma(series, rest, coefficient)
    return series * _from_bits((np.int64(power) + _BIAS) << 52)


@inner
def log(x: float) -> float:
    """Return ln x, within some units of the last place, for a positive normal x."""
    bits = _to_bits(x)
    power = (bits >> 52) - _BIAS
    mantissa = _from_bits((bits & _FRACTION) | (_BIAS << 52))
    if mantissa > _SQRT2:
        mantissa *= 0.5
        power += 1
    ratio = (mantissa - 1.0) / (mantissa + 1.0)
    square, series = ratio * ratio, 0.0
    for coefficient in _LOG:
        series = fma(series, square, coefficient)
    whole = float(power)
    logarithm: float = fma(whole, _LN2_HIGH, fma(whole, _LN2_LOW, 2.0 * ratio * series))
    return logarithm


@inner
def power(x: float, exponent: float) -> float:
    """Return x^exponent for x at least 0; 0 for x = 0."""
    return exp(exponent * log(x)) if x > 0.0 else 0.0


@inner
def add_product(x: Floats32, w: Floats32, out: Floats32) -> None:
    """Add x w to `out`, each sum in the order of its terms; x: [rows, terms], w: [terms, width], out: [rows, width].

    Four rows by four terms a pass keep what is multiplied in registers; what is left over takes the same steps.
    """
    rows, terms, width = x.shape[0], x.shape[1], w.shape[1]
    r = 0
    while r < rows:
        i, end = 0, min(r + 4, rows)
        while r + 4 <= rows and i + 4 <= terms:
            a00, a01, a02, a03 = x[r, i], x[r, i + 1], x[r, i + 2], x[r, i + 3]
            a10, a11, a12, a13 = x[r + 1, i], x[r + 1, i + 1], x[r + 1, i + 2], x[r + 1, i + 3]
            a20, a21, a22, a23 = x[r + 2, i], x[r + 2, i + 1], x[r + 2, i + 2], x[r + 2, i + 3]
            a30, a31, a32, a33 = x[r + 3, i], x[r + 3, i + 1], x[r + 3, i + 2], x[r + 3, i + 3]
            for j in range(width):
                w0, w1, w2, w3 = w[i, j], w[i + 1, j], w[i + 2, j], w[i + 3, j]
                out[r, j] = fma(a03, w3, fma(a02, w2, fma(a01, w1, fma(a00, w0, out[r, j]))))
                out[r + 1, j] = fma(a13, w3, fma(a12, w2, fma(a11, w1, fma(a10, w0, out[r + 1, j]))))
                out[r + 2, j] = fma(a23, w3, fma(a22, w2, fma(a21, w1, fma(a20, w0, out[r + 2, j]))))
                out[r + 3, j] = fma(a33, w3, fma(a32, w2, fma(a31, w1, fma(a30, w0, out[r + 3, j]))))
            i += 4
        for left in range(r, end):
            for term in range(i, terms):
                a = x[left, term]
                for j in range(width):
                    out[left, j] = fma(a, w[term, j], out[left, j])
        r = end


@inner
def write_outer(x: Floats32, g: Floats32, out: Floats32) -> None:
    """Write x^T g, each sum in the order of the rows; x: [rows, in], g: [rows, width], out: [in, width]."""
    rows, terms, width = x.shape[0], x.shape[1], g.shape[1]
    out[:] = ZERO
    i = 0
    while i + 4 <= terms:
        b = 0
        while b + 4 <= rows:
            a00, a01, a02, a03 = x[b, i], x[b + 1, i], x[b + 2, i], x[b + 3, i]
            a10, a11, a12, a13 = x[b, i + 1], x[b + 1, i + 1], x[b + 2, i + 1], x[b + 3, i + 1]
            a20, a21, a22, a23 = x[b, i + 2], x[b + 1, i + 2], x[b + 2, i + 2], x[b + 3, i + 2]
            a30, a31, a32, a33 = x[b, i + 3], x[b + 1, i + 3], x[b + 2, i + 3], x[b + 3, i + 3]
            for j in range(width):
                g0, g1, g2, g3 = g[b, j], g[b + 1, j], g[b + 2, j], g[b + 3, j]
                out[i, j] = fma(a03, g3, fma(a02, g2, fma(a01, g1, fma(a00, g0, out[i, j]))))
                out[i + 1, j] = fma(a13, g3, fma(a12, g2, fma(a11, g1, fma(a10, g0, out[i + 1, j]))))
                out[i + 2, j] = fma(a23, g3, fma(a22, g2, fma(a21, g1, fma(a20, g0, out[i + 2, j]))))
                out[i + 3, j] = fma(a33, g3, fma(a32, g2, fma(a31, g1, fma(a30, g0, out[i + 3, j]))))
            b += 4
        while b < rows:
            for part in range(4):
                a = x[b, i + part]
                for j in range(width):
                    out[i + part, j] = fma(a, g[b, j], out[i + part, j])
            b += 1
        i += 4
    while i < terms:
        for b in range(rows):
            a = x[b, i]
            for j in range(width):
                out[i, j] = fma(a, g[b, j], out[i, j])
        i += 1
