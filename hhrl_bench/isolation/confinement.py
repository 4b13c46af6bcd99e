"""Confinement: what a process gives up before it runs a user's code, where the system can see to it."""

import os
import sys
from contextlib import suppress
from pathlib import Path

import numba
from numba.core.caching import Cache

from hhrl_bench.isolation.landlock import keep_writes_below

_OUT_OF_MEMORY_SCORE = "1000"


def confine(folder: Path, memory: int) -> None:
    """Let this process and what it begins write below ``folder`` alone, each with ``memory`` bytes of data at most.

    The limit is on data, so that address space can be reserved at will, as GPUs' drivers do. Where memory runs out all
    the same, Linux ends these processes first. Kernels that are compiled from now on are not kept.
    """
    _leave_caches(folder)
    if sys.platform != "win32":
        import resource  # noqa: PLC0415 - Windows has none

        for limit, value in ((resource.RLIMIT_DATA, memory), (resource.RLIMIT_CORE, 0)):
            hard = resource.getrlimit(limit)[1]
            allowed = value if hard == resource.RLIM_INFINITY else min(value, hard)
            resource.setrlimit(limit, (allowed, allowed))
    if sys.platform == "linux":
        with suppress(OSError):
            Path("/proc/self/oom_score_adj").write_text(_OUT_OF_MEMORY_SCORE)
        keep_writes_below(folder)


def _leave_caches(folder: Path) -> None:
    """Let numba read our kernels where it has found them, but write none there; a user's own go into the folder."""
    Cache.save_overload = lambda *_: None  # type: ignore[method-assign]
    os.environ["NUMBA_CACHE_DIR"] = str(folder / "numba")
    numba.config.reload_config()  # type: ignore[no-untyped-call]
    os.environ["TMPDIR"] = str(folder)
