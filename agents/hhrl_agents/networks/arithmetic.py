"""Arithmetic that gives the same bits on every processor: fused products in a fixed order, and exp, log and pow.

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
from hhrl_envs.simulation.engine.compilation import inner, spliced

ZERO, ONE = np.float32(0.0), np.float32(1.0)

LANES = 16
"""Numbers in a vector of the products; a processor with shorter ones takes several for it."""

if TYPE_CHECKING:

    def matrix(numbers: Any, place: int, rows: int, width: int) -> Any:
        """Return the numbers from a place on as [rows, width], a view that does not keep them alive."""

    def apart() -> None:
        """Keep the function that calls this apart where others call it: the compiler does not inline it."""

    def _add_tile_4_4(x: Floats32, by_row: int, by_term: int, w: Floats32, out: Floats32, r: int, j: int) -> None: ...

    def _add_tile_1_4(x: Floats32, by_row: int, by_term: int, w: Floats32, out: Floats32, r: int, j: int) -> None: ...

    def _add_tile_8_1(x: Floats32, by_row: int, by_term: int, w: Floats32, out: Floats32, r: int, j: int) -> None: ...

    def _add_tile_1_1(x: Floats32, by_row: int, by_term: int, w: Floats32, out: Floats32, r: int, j: int) -> None: ...

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

    def _tile(rows: int, vectors: int) -> Any:
        """Return what adds x w to so many rows and vectors of `out` from (r, j) on, its sums kept in registers.

        A loop over the terms multiplies an element of x, in every lane, with a vector of w. LLVM does not find these
        vectors by itself. A single vector may be cut short where the columns end.
        """
        vector = ir.VectorType(ir.FloatType(), LANES)
        flags, lane, lanes = (ir.VectorType(ir.IntType(bits), LANES) for bits in (1, 32, 64))

        def add_tile(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            x, w, out = (context.make_array(signature.args[k])(context, builder, values[k]) for k in (0, 3, 4))
            by_row, by_term, r, j = (values[k] for k in (1, 2, 5, 6))
            width = cgutils.unpack_tuple(builder, w.shape, 2)[1]

            def declared(name: str, result: Any, *arguments: Any) -> Any:
                return cgutils.get_or_insert_function(builder.module, ir.FunctionType(result, arguments), name)

            def further(index: Any, count: int) -> Any:
                return builder.add(index, ir.Constant(index.type, count))

            def in_every_lane(element: Any, kind: Any) -> Any:
                undefined = ir.Constant(kind, ir.Undefined)
                first = builder.insert_element(undefined, element, ir.Constant(ir.IntType(32), 0))
                return builder.shuffle_vector(first, undefined, ir.Constant(lane, [0] * LANES))

            def vectors_at(array: Any, row: Any) -> list[Any]:
                first = builder.add(builder.mul(row, width), j)
                places = [builder.gep(array.data, [further(first, LANES * v)]) for v in range(vectors)]
                return [builder.bitcast(place, vector.as_pointer()) for place in places]

            def load(place: Any) -> Any:
                if vectors > 1:
                    return builder.load(place, align=4)
                zeros = ir.Constant(vector, None)
                return builder.call(masked_load, [place, align, inside, zeros])

            def store(numbers: Any, place: Any) -> None:
                if vectors > 1:
                    builder.store(numbers, place, align=4)
                else:
                    builder.call(masked_store, [numbers, place, align, inside])

            align, pointer = ir.Constant(ir.IntType(32), 4), vector.as_pointer()
            numbered = ir.Constant(lanes, list(range(LANES)))
            inside = builder.icmp_signed("<", numbered, in_every_lane(builder.sub(width, j), lanes))
            masked_load = declared(f"llvm.masked.load.v{LANES}f32.p0v{LANES}f32", vector, pointer, align.type, flags, vector)
            masked_store = declared(
                f"llvm.masked.store.v{LANES}f32.p0v{LANES}f32", ir.VoidType(), vector, pointer, align.type, flags
            )
            multiply_add = declared(f"llvm.fma.v{LANES}f32", vector, vector, vector, vector)

            places = [vectors_at(out, further(r, row)) for row in range(rows)]
            sums = [[cgutils.alloca_once_value(builder, load(at)) for at in row] for row in places]
            with cgutils.for_range(builder, cgutils.unpack_tuple(builder, w.shape, 2)[0]) as loop:
                factors = [load(at) for at in vectors_at(w, loop.index)]
                for row in range(rows):
                    place = builder.add(builder.mul(further(r, row), by_row), builder.mul(loop.index, by_term))
                    element = in_every_lane(builder.load(builder.gep(x.data, [place]), align=4), vector)
                    for factor, kept in zip(factors, sums[row], strict=True):
                        builder.store(builder.call(multiply_add, [element, factor, builder.load(kept)]), kept)
            for row in range(rows):
                for at, kept in zip(places[row], sums[row], strict=True):
                    store(builder.load(kept), at)
            return context.get_dummy_value()

        @intrinsic
        def tile(_: Any, x: Any, by_row: Any, by_term: Any, w: Any, out: Any, r: Any, j: Any) -> Any:
            return types.void(x, by_row, by_term, w, out, r, j), add_tile

        return tile

    _add_tile_4_4, _add_tile_1_4, _add_tile_8_1, _add_tile_1_1 = _tile(4, 4), _tile(1, 4), _tile(8, 1), _tile(1, 1)


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


@spliced
def add_product(x: Floats32, w: Floats32, out: Floats32) -> None:
    """Add x w to `out`, each sum in the order of its terms; w: [terms, width], out: [rows, width].

    x: [rows, terms or more], of which the first `terms` columns count.
    """
    _add_product(x, x.shape[1], np.int64(1), w, out)


@spliced
def write_outer(x: Floats32, g: Floats32, out: Floats32) -> None:
    """Write x^T g, each sum in the order of the rows; g: [rows, width], out: [in, width].

    x: [rows, in or more], of which the first `in` columns count.
    """
    clear(out)
    _add_product(x, np.int64(1), x.shape[1], g, out)


@inner
def clear(numbers: Floats32) -> None:
    """Set a matrix to zero."""
    for r in range(numbers.shape[0]):
        for j in range(numbers.shape[1]):
            numbers[r, j] = ZERO


@inner
def _add_product(x: Floats32, by_row: int, by_term: int, w: Floats32, out: Floats32) -> None:
    """Add to out[r, j] the sum over i of x w[i, j], where x is that at `r by_row + i by_term` of its numbers.

    A sum waits for the one before it, so that eight rows or four vectors are computed beside each other.
    """
    apart()
    rows, width, j = out.shape[0], out.shape[1], 0
    while j < width:
        r = 0
        if j + 4 * LANES <= width:
            while r + 4 <= rows:
                _add_tile_4_4(x, by_row, by_term, w, out, r, j)
                r += 4
            while r < rows:
                _add_tile_1_4(x, by_row, by_term, w, out, r, j)
                r += 1
            j += 4 * LANES
        else:
            while r + 8 <= rows:
                _add_tile_8_1(x, by_row, by_term, w, out, r, j)
                r += 8
            while r < rows:
                _add_tile_1_1(x, by_row, by_term, w, out, r, j)
                r += 1
            j += LANES
