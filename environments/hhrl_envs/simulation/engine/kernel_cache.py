"""Where compiled kernels are kept: where nobody else can write, for numba unpickles what it finds there."""

import hashlib
import logging
import os
import stat
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from itertools import chain
from pathlib import Path
from typing import Any, cast

import numba
from numba.core.caching import CompileResultCacheImpl, FunctionCache

_FOLDERS = ("scenario", "simulation", "networks", "replay", "algorithms")
_SAID = "HHRL_KERNEL_PLACE_SAID"  # in the environment, which the processes of workers and of users' agents inherit


def digest_sources(package: Path) -> str:
    """Return the SHA-256 of all sources in a package's folder that kernels or their constants come from."""
    sources = [*package.glob("*.py"), *chain(*((package / folder).rglob("*.py") for folder in _FOLDERS))]
    return hashlib.sha256(b"".join(source.read_bytes() for source in sorted(sources))).hexdigest()


_digest = cache(digest_sources)


def is_private(folder: Path) -> bool:
    """Return whether a folder is this user's and nobody else may write in it; true where there are no such modes."""
    if os.name != "posix":
        return True
    status = folder.stat()
    return status.st_uid == os.geteuid() and not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


class _PrivateFolder:
    """Makes a place that numba knows of one that is only taken if it is private."""

    def ensure_cache_path(self) -> None:
        folder = Path(self.get_cache_path())  # type: ignore[attr-defined]
        if folder.parts[:1] == ("~",):
            raise FileNotFoundError("the user has no home")
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not is_private(folder):
            raise PermissionError(f"others can write in {folder}")
        super().ensure_cache_path()  # type: ignore[misc]


class _Places(CompileResultCacheImpl):
    _locator_classes: list[Any] = [  # noqa: RUF012 - as numba has declared it
        type(place.__name__, (_PrivateFolder, place), {})
        for place in CompileResultCacheImpl._locator_classes  # noqa: SLF001
    ]


class KernelCache(FunctionCache):
    """Keeps a kernel, once compiled, for later processes; never reads a folder that others can write.

    An entry that cannot be read, say because a kill or a full disk cut it short, is compiled and written again.

    Raises:
        OSError: if there is no folder for it.
        RuntimeError: the same, as numba says it.
    """

    _impl_class = _Places

    def __init__(self, function: Callable[..., object]) -> None:
        super().__init__(function)  # type: ignore[no-untyped-call]
        if not is_private(Path(self.cache_path)):  # NUMBA_CACHE_LOCATOR_CLASSES can name places that do not ask
            raise PermissionError(self.cache_path)
        # numba dates a cache entry by the function's own file, so a changed callee in another file would go unnoticed
        # and the old physics would run on: date it by all sources of kernels.
        entries = self._cache_file
        entries._source_stamp = (entries._source_stamp, *_sources(function))  # noqa: SLF001

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return what is kept for a signature; None if nothing is, or nothing that can be read."""
        with suppress(Exception):  # unpickling half a file can raise anything
            return super().load_overload(sig, target_context)  # type: ignore[no-untyped-call]
        with suppress(OSError):
            self.flush()  # type: ignore[no-untyped-call]
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled for a signature, if it still can be."""
        with suppress(OSError):
            super().save_overload(sig, data)  # type: ignore[no-untyped-call]


def keep(kernel: Any) -> None:
    """Keep what is compiled of a kernel on disk; say once if that is not done, or not where it was asked for."""
    try:
        kernel._cache = KernelCache(kernel.py_func)  # noqa: SLF001
    except (OSError, RuntimeError):
        _say("compiled kernels are not kept, each process compiles anew; set NUMBA_CACHE_DIR to a folder of your own")
    else:
        asked, place = cast(Any, numba.config).CACHE_DIR, Path(kernel._cache.cache_path)  # noqa: SLF001
        if asked and not place.is_relative_to(asked):
            _say(f"NUMBA_CACHE_DIR is passed over: {asked} cannot be written, or others than you can write there")


def _say(line: str) -> None:
    """Say a line, unless this process has said one, or the process that began it."""
    if _SAID not in os.environ:
        os.environ[_SAID] = "1"
        logging.getLogger("hhrl_envs").warning("hhrl_envs: %s", line)


def _sources(function: Callable[..., object]) -> tuple[str, str]:
    """Return the digests of the sources that a kernel can come from: this package's and its own package's."""
    own = Path(function.__code__.co_filename).parents[function.__module__.count(".") - 1]
    return _digest(Path(__file__).parents[2]), _digest(own)
