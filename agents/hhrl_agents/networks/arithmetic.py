"""Arithmetic that gives the same bits on every processor: fused multiply-add, exp, log and pow.

IEEE 754 fixes the results of + - * / sqrt and fma. What is built from them here, in an order that the source fixes,
depends on no library of mathematics, vector width or number of threads: vectors run along outputs, never along a sum.
"""

from typing import TYPE_CHECKING, Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numba.np.arrayobj import populate_array

from hhrl_envs.arrays import Floats, Floats32
from hhrl_envs.simulation.engine.compilation import inner

ZERO, ONE = np.float32(0.0), np.float32(1.0)

if TYPE_CHECKING:

    def matrix(numbers: Any, place: int, rows: int, width: int) -> Any:
        """Return the numbers from a place on as [rows, width], a view that does not keep them alive."""

    def apart() -> None:
        """Keep the function that calls this apart where others call it: the compiler does not inline it."""

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

    @intrinsic
    def matrix(_: Any, numbers: Any, place: Any, rows: Any, width: Any) -> Any:
        """Return the numbers from a place on as [rows, width], a view that does not keep them alive.

        It compiles to a few instructions, which slicing and reshaping do not.
        """
        kind = types.Array(numbers.dtype, 2, "C")

        def view(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            source = context.make_array(signature.args[0])(context, builder, values[0])
            made = context.make_array(kind)(context, builder)
            size = ir.Constant(values[1].type, context.get_abi_sizeof(context.get_data_type(kind.dtype)))
            populate_array(
                made,
                data=builder.gep(source.data, [values[1]]),
                shape=values[2:],
                strides=[builder.mul(values[3], size), size],
                itemsize=size,
                meminfo=None,
            )
            return made._getvalue()  # noqa: SLF001

        return kind(numbers, place, rows, width), view

    @intrinsic
    def apart(_: Any) -> Any:
        """Keep the function that calls this apart where others call it: the compiler does not inline it."""

        def mark(context: Any, builder: Any, _signature: Any, _values: Any) -> Any:
            builder.function.attributes.add("noinline")
            return context.get_dummy_value()

        return types.void(), mark


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
def raise_all(numbers: Floats, exponent: float) -> None:
    """Raise numbers of at least 0 to a power, in a loop of its own, which vectorises."""
    for n in range(numbers.size):
        numbers[n] = power(numbers[n], exponent)


@inner
def clear(numbers: Floats32) -> None:
    """Set a matrix to zero."""
    for r in range(numbers.shape[0]):
        for j in range(numbers.shape[1]):
            numbers[r, j] = ZERO
