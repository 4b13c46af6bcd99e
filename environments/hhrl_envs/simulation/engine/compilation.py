"""The one way in which this package compiles its kernels."""

from collections.abc import Callable, Iterable
from functools import reduce
from types import SimpleNamespace
from typing import Any, TypeVar, cast

import numba
import numpy as np
from numba import njit
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler

from hhrl_envs.errors import InputError
from hhrl_envs.simulation.engine.kernel_cache import keep

if cast(Any, numba.config).DISABLE_JIT:
    raise InputError("NUMBA_DISABLE_JIT is set, but the simulator only runs compiled; unset it")

F = TypeVar("F", bound=Callable[..., object])

unsigned = cast(Callable[[float], int], np.uint64)
"""Makes an index unsigned; see ``layout`` for why."""


class _Part(JITCodeLibrary):
    """What LLVM gets of a part of kernels: no more than its text, which each kernel optimises with all else of its own.

    numba would optimise every part by itself and once more in all that call it, and make machine code of it each time.
    """

    def _optimize_final_module(self) -> None: ...

    def _finalize_final_module(self) -> None:
        self._finalized = True

    @property
    def codegen(self) -> Any:
        """Return what a function that Python calls would be made known to."""
        return SimpleNamespace(set_env=lambda *_: None)


class _PartCompiler(Compiler):
    def define_pipelines(self) -> Any:
        """Return numba's usual passes, for a function that becomes a part."""
        state = self.state
        state.library = _Part(state.targetctx.codegen(), state.func_id.func_qualname)  # type: ignore[no-untyped-call]
        return super().define_pipelines()  # type: ignore[no-untyped-call]


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


def _part(function: F, **options: Any) -> F:
    wrappers = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    return cast(F, _compiled(function, pipeline_class=_PartCompiler, **wrappers, **options))


def inner(function: F) -> F:
    """Return ``function`` compiled as a part of kernels; without wrapper, cache and machine code that is faster.

    Python must not call it: nothing would catch the fall.
    """
    return _part(function)


def spliced(function: F) -> F:
    """Return ``function`` as a part of kernels that is put into their text where they call it.

    It saves compiling on its own what does little but call others.
    """
    return cast(F, _compiled(function, inline="always"))


def inlined(function: F) -> F:
    """Return ``function`` compiled as a part of kernels that LLVM inlines however long it is.

    A loop over lanes vectorises only where all that it calls for a lane is inlined.
    """
    return _part(function, forceinline=True)


def in_turn(functions: Iterable[F]) -> F:
    """Return a part of kernels that calls these functions, one after the other, with the same arguments."""

    def append(first: F, last: F) -> F:
        def both(*arguments: Any) -> None:
            first(*arguments)
            last(*arguments)

        return cast(F, inlined(both))

    return reduce(append, functions)
