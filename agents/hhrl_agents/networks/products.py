"""Products of matrices that give the same bits on every processor and for any number of rows.

A sum takes its terms in their order, one fused multiply-add each. Vectors run along the columns of the result, never
along a sum.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from hhrl_agents.networks.arithmetic import apart, clear
from hhrl_envs.arrays import Floats32
from hhrl_envs.simulation.engine.compilation import inner, spliced

_number = cast(Callable[[int], int], np.int64)
"""Hides a constant, for which numba would compile what it is passed to once more."""

LANES = 16
"""Numbers in a vector; a processor with shorter ones takes several for it."""

_VECTOR = ir.VectorType(ir.FloatType(), LANES)
_FLAGS, _PLACES, _NUMBERS = (ir.VectorType(ir.IntType(bits), LANES) for bits in (1, 32, 64))
_ALIGNED = ir.Constant(ir.IntType(32), 4)


class _Vectors:
    """Writes instructions on vectors of float32; with `left`, only the lanes before this number are in memory."""

    def __init__(self, builder: Any, left: Any = None) -> None:
        self._builder = builder
        numbered = ir.Constant(_NUMBERS, list(range(LANES)))
        self._inside = None if left is None else builder.icmp_signed("<", numbered, self._repeated(left, _NUMBERS))

    def load(self, place: Any) -> Any:
        """Return the vector at a place; lanes that are not in memory are 0."""
        place = self._builder.bitcast(place, _VECTOR.as_pointer())
        if self._inside is None:
            return self._builder.load(place, align=4)
        return self._call("masked.load", _VECTOR, place, _ALIGNED, self._inside, ir.Constant(_VECTOR, None))

    def store(self, numbers: Any, place: Any) -> None:
        """Store a vector at a place."""
        place = self._builder.bitcast(place, _VECTOR.as_pointer())
        if self._inside is None:
            self._builder.store(numbers, place, align=4)
        else:
            self._call("masked.store", ir.VoidType(), numbers, place, _ALIGNED, self._inside)

    def repeated(self, number: Any) -> Any:
        """Return a number in every lane."""
        return self._repeated(number, _VECTOR)

    def multiply_add(self, a: Any, b: Any, c: Any) -> Any:
        """Return a b + c, rounded once."""
        return self._call("fma", _VECTOR, a, b, c)

    def _repeated(self, number: Any, kind: Any) -> Any:
        undefined = ir.Constant(kind, ir.Undefined)
        first = self._builder.insert_element(undefined, number, ir.Constant(ir.IntType(32), 0))
        return self._builder.shuffle_vector(first, undefined, ir.Constant(_PLACES, [0] * LANES))

    def _call(self, name: str, result: Any, *arguments: Any) -> Any:
        kind = f"v{LANES}f32"
        full = f"llvm.{name}.{kind}" if name == "fma" else f"llvm.{name}.{kind}.p0{kind}"
        signature = ir.FunctionType(result, [argument.type for argument in arguments])
        function = cast(Any, cgutils).get_or_insert_function(self._builder.module, signature, full)
        return self._builder.call(function, arguments)


if TYPE_CHECKING:

    def _add_tile_4_4(x: Floats32, by_row: int, by_term: int, w: Floats32, out: Floats32, r: int, j: int) -> None: ...

    def _add_tile_1_4(x: Floats32, by_row: int, by_term: int, w: Floats32, out: Floats32, r: int, j: int) -> None: ...

    def _add_tile_8_1(x: Floats32, by_row: int, by_term: int, w: Floats32, out: Floats32, r: int, j: int) -> None: ...

    def _add_tile_1_1(x: Floats32, by_row: int, by_term: int, w: Floats32, out: Floats32, r: int, j: int) -> None: ...

else:

    def _tile(rows: int, vectors: int) -> Any:
        """Return what adds x w to so many rows and vectors of `out` from (r, j) on, its sums kept in registers.

        A loop over the terms multiplies an element of x, in every lane, with a vector of w. LLVM does not find these
        vectors by itself. A single vector may reach beyond the last column.
        """

        def add_tile(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            x, w, out = (context.make_array(signature.args[k])(context, builder, values[k]) for k in (0, 3, 4))
            by_row, by_term, r, j = (values[k] for k in (1, 2, 5, 6))
            terms, width = cgutils.unpack_tuple(builder, w.shape, 2)
            lanes = _Vectors(builder, builder.sub(width, j) if vectors == 1 else None)

            def further(index: Any, count: int) -> Any:
                return builder.add(index, ir.Constant(index.type, count))

            def places(array: Any, row: Any) -> list[Any]:
                first = builder.add(builder.mul(row, width), j)
                return [builder.gep(array.data, [further(first, LANES * v)]) for v in range(vectors)]

            goals = [place for row in range(rows) for place in places(out, further(r, row))]
            sums = [cgutils.alloca_once_value(builder, lanes.load(goal)) for goal in goals]
            with cgutils.for_range(builder, terms) as loop:
                factors = [lanes.load(place) for place in places(w, loop.index)]
                for row in range(rows):
                    place = builder.add(builder.mul(further(r, row), by_row), builder.mul(loop.index, by_term))
                    element = lanes.repeated(builder.load(builder.gep(x.data, [place]), align=4))
                    for factor, kept in zip(factors, sums[row * vectors :], strict=False):
                        builder.store(lanes.multiply_add(element, factor, builder.load(kept)), kept)
            for kept, goal in zip(sums, goals, strict=True):
                lanes.store(builder.load(kept), goal)
            return context.get_dummy_value()

        @intrinsic
        def tile(_: Any, x: Any, by_row: Any, by_term: Any, w: Any, out: Any, r: Any, j: Any) -> Any:
            return types.void(x, by_row, by_term, w, out, r, j), add_tile

        return tile

    _add_tile_4_4, _add_tile_1_4, _add_tile_8_1, _add_tile_1_1 = _tile(4, 4), _tile(1, 4), _tile(8, 1), _tile(1, 1)


@spliced
def add_product(x: Floats32, w: Floats32, out: Floats32) -> None:
    """Add x w to `out`, each sum in the order of its terms; w: [terms, width], out: [rows, width].

    x: [rows, terms or more], of which the first `terms` columns count.
    """
    _add_product(x, x.shape[1], _number(1), w, out)


@spliced
def write_outer(x: Floats32, g: Floats32, out: Floats32) -> None:
    """Write x^T g, each sum in the order of the rows; g: [rows, width], out: [in, width].

    x: [rows, in or more], of which the first `in` columns count.
    """
    clear(out)
    _add_product(x, _number(1), x.shape[1], g, out)


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
