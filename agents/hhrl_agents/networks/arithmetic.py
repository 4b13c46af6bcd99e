"""Arithmetic that gives the same bits on every processor: fused multiply-add, exp, log and pow.

IEEE 754 fixes the results of + - * / sqrt and fma. What is built from them here, in an order that the source fixes,
depends on no library of mathematics, vector width or number of threads: vectors run along outputs, never along a sum.
"""

from typing import TYPE_CHECKING, Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import populate_array

from hhrl_envs.arrays import Floats, Floats32
from hhrl_envs.simulation.engine.compilation import inner

ZERO, ONE = np.float32(0.0), np.float32(1.0)

if TYPE_CHECKING:

    def matrix(numbers: Any, place: int, rows: int, width: int) -> Any:
        """Return the numbers from a place on as [rows, width], a view."""

    def block(work: Any, capacity: int, place: int, rows: int, width: int, first: int = 0) -> Any:
        """Return rows of a block of a workspace from the `first` on, [rows, width], a view."""

    def stack(count: int) -> Any:
        """Return room for so many numbers, float64 [1, count], until the function that calls this returns."""

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

    def _view(context: Any, builder: Any, kind: Any, data: Any, rows: Any, width: Any) -> Any:
        """Return numbers as [rows, width]: a few instructions, which slicing and reshaping are not."""
        made = context.make_array(kind)(context, builder)
        size = ir.Constant(width.type, context.get_abi_sizeof(context.get_data_type(kind.dtype)))
        strides = [builder.mul(width, size), size]
        populate_array(made, data=data, shape=[rows, width], strides=strides, itemsize=size, meminfo=None)
        return made._getvalue()  # noqa: SLF001

    @intrinsic
    def matrix(_: Any, numbers: Any, place: Any, rows: Any, width: Any) -> Any:
        """Return the numbers from a place on as [rows, width], a view."""
        kind = types.Array(numbers.dtype, 2, "C")

        def view(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            source = context.make_array(signature.args[0])(context, builder, values[0])
            return _view(context, builder, kind, builder.gep(source.data, [values[1]]), *values[2:])

        return kind(numbers, place, rows, width), view

    @intrinsic
    def block(_: Any, work: Any, capacity: Any, place: Any, rows: Any, width: Any, first: Any = 0) -> Any:  # noqa: ARG001
        """Return rows of a block of a workspace from the `first` on, [rows, width], a view."""
        kind = types.Array(work.dtype, 2, "C")

        def view(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            source = context.make_array(signature.args[0])(context, builder, values[0])
            capacity, place, rows, width, first = values[1:]
            begin = builder.add(builder.mul(place, capacity), builder.mul(first, width))
            return _view(context, builder, kind, builder.gep(source.data, [begin]), rows, width)

        return kind(work, *(types.intp,) * 5), view

    @intrinsic(prefer_literal=True)
    def stack(_: Any, count: Any) -> Any:
        """Return room for so many numbers, float64 [1, count], until the function that calls this returns."""
        kind = types.Array(types.float64, 2, "C")

        def view(context: Any, builder: Any, _signature: Any, _values: Any) -> Any:
            one, size = (ir.Constant(ir.IntType(64), number) for number in (1, count.literal_value))
            data = cgutils.alloca_once(builder, ir.DoubleType(), size)
            return _view(context, builder, kind, data, one, size)

        return kind(count), view

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
    """Raise the numbers of a matrix, at least 0, to a power, in loops of their own, which vectorise."""
    for r in range(numbers.shape[0]):
        for j in range(numbers.shape[1]):
            numbers[r, j] = power(numbers[r, j], exponent)


@inner
def clear(numbers: Floats32) -> None:
    """Set a matrix to zero."""
    for r in range(numbers.shape[0]):
        for j in range(numbers.shape[1]):
            numbers[r, j] = ZERO
