"""The one way in which this package compiles its kernels."""

import hashlib
from collections.abc import Callable, Iterable
from functools import cache, reduce
from itertools import chain
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
from numba import njit

F = TypeVar("F", bound=Callable[..., object])

unsigned = cast(Callable[[float], int], np.uint64)
"""Makes an index unsigned; see ``layout`` for why."""


_FOLDERS = ("scenario", "simulation", "networks", "replay", "algorithms")


def digest_sources(package: Path) -> str:
    """Return the SHA-256 of all sources in a package's folder that kernels or their constants come from."""
    sources = [*package.glob("*.py"), *chain(*((package / folder).rglob("*.py") for folder in _FOLDERS))]
    return hashlib.sha256(b"".join(source.read_bytes() for source in sorted(sources))).hexdigest()


_digest = cache(digest_sources)


def _sources(function: Callable[..., object]) -> tuple[str, str]:
    """Return the digests of the sources that a kernel can come from: this package's and its own package's."""
    own = Path(function.__code__.co_filename).parents[function.__module__.count(".") - 1]
    return _digest(Path(__file__).parents[2]), _digest(own)


def _compiled(function: Callable[..., object], **options: Any) -> Any:
    return cast(Any, njit)(nogil=True, error_model="numpy", **options)(function)


def kernel(function: F) -> F:
    """Return ``function`` compiled: cached on disk, without the interpreter lock, with exact IEEE arithmetic.

    ``error_model="numpy"`` lets a division by zero give inf instead of an exception, without which no loop with a
    division would vectorise. ``fastmath`` stays off: the same bits on every machine, in every batch.
    """
    compiled = _compiled(function, cache=True, no_cfunc_wrapper=True)
    # numba dates a cache entry by the function's own file, so a changed callee in another file would go unnoticed and
    # the old physics would run on: date it by all sources of kernels.
    entries = compiled._cache._cache_file  # noqa: SLF001
    entries._source_stamp = (entries._source_stamp, *_sources(function))  # noqa: SLF001
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
