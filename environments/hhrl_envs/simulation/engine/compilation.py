"""The one way in which this package compiles its kernels."""

from collections.abc import Callable, Iterable
from functools import reduce
from typing import Any, TypeVar, cast

import numba
import numpy as np
from numba import njit

from hhrl_envs.errors import InputError
from hhrl_envs.simulation.engine.kernel_cache import keep

if cast(Any, numba.config).DISABLE_JIT:
    raise InputError("NUMBA_DISABLE_JIT is set, but the simulator only runs compiled; unset it")

F = TypeVar("F", bound=Callable[..., object])

unsigned = cast(Callable[[float], int], np.uint64)
"""Makes an index unsigned; see ``layout`` for why."""


def _compiled(function: Callable[..., object], **options: Any) -> Any:
    return cast(Any, njit)(nogil=True, error_model="numpy", **options)(function)


def kernel(function: F) -> F:
    """Return ``function`` compiled: cached on disk, without the interpreter lock, with exact IEEE arithmetic.

    ``error_model="numpy"`` lets a division by zero give inf instead of an exception, without which no loop with a
    division would vectorise. ``fastmath`` stays off: the same bits on every machine, in every batch.
    """
    compiled = _compiled(function, no_cfunc_wrapper=True)
    keep(compiled)
    return cast(F, compiled)


def inner(function: F) -> F:
    """Return ``function`` compiled as a part of kernels; without a wrapper and a cache of its own that is faster.

    Python must not call it: nothing would catch the fall.
    """
    return cast(F, _compiled(function, no_cpython_wrapper=True, no_cfunc_wrapper=True))


def spliced(function: F) -> F:
    """Return ``function`` as a part of kernels that is put into their text where they call it.

    It saves compiling on its own what does little but call others.
    """
    return cast(F, _compiled(function, inline="always"))


def inlined(function: F) -> F:
    """Return ``function`` compiled as a part of kernels that LLVM inlines however long it is.

    A loop over lanes vectorises only where all that it calls for a lane is inlined.
    """
    return cast(F, _compiled(function, no_cpython_wrapper=True, no_cfunc_wrapper=True, forceinline=True))


def in_turn(functions: Iterable[F]) -> F:
    """Return a part of kernels that calls these functions, one after the other, with the same arguments."""

    def append(first: F, last: F) -> F:
        def both(*arguments: Any) -> None:
            first(*arguments)
            last(*arguments)

        return cast(F, inlined(both))

    return reduce(append, functions)
