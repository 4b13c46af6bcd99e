"""Landlock, which Linux has had since 5.13: a process gives up its rights to change files, and gets none back."""

import ctypes
import os
import struct
import sys
from collections.abc import Iterable
from glob import glob
from pathlib import Path

_CREATE_RULESET, _ADD_RULE, _RESTRICT_SELF = 444, 445, 446
_ASK_VERSION = 1
_PATH_BENEATH = 1
_NO_NEW_PRIVILEGES = 38

_WRITE_FILE, _TRUNCATE, _REFER = 1 << 1, 1 << 14, 1 << 13
_MAKE_AND_REMOVE = sum(1 << bit for bit in range(4, 13))
_SCOPE_SIGNALS = 1 << 1

_TRUNCATE_SINCE, _REFER_SINCE, _NETWORK_SINCE, _SCOPES_SINCE = 3, 2, 4, 6

DEVICES = ("null", "zero", "full", "random", "urandom", "nvidia*", "dri", "kfd")
"""What of ``/dev`` stays writable: the devices that hold nothing, and those of GPUs."""


def version() -> int:
    """Return the version of Landlock's interface that this system has, 0 if it has none."""
    return max(_call(_CREATE_RULESET, None, 0, _ASK_VERSION), 0) if sys.platform == "linux" else 0


def keep_writes_below(folder: Path) -> None:
    """Let this process and what it begins change no file outside a folder, and signal no process but its own.

    It can then also not trace any other process. Devices in ``DEVICES`` and its own ``/proc/self`` stay writable, as
    drivers of GPUs write there. Only this thread and what it begins is bound, so it has to be the only one.

    Raises:
        OSError: if the system refuses.
    """
    known = version()
    if not known:
        return
    rights = _WRITE_FILE | _MAKE_AND_REMOVE
    rights |= _REFER * (known >= _REFER_SINCE) | _TRUNCATE * (known >= _TRUNCATE_SINCE)
    attributes = struct.pack("=QQQ", rights, 0, _SCOPE_SIGNALS * (known >= _SCOPES_SINCE))
    length = 8 * (1 + (known >= _NETWORK_SINCE) + (known >= _SCOPES_SINCE))
    ruleset = _require(_call(_CREATE_RULESET, attributes, length, 0))
    _allow(ruleset, [folder], rights)
    devices = [Path(path) for name in DEVICES for path in glob(f"/dev/{name}")]  # noqa: PTH207 - devices, not a tree
    _allow(ruleset, [*devices, Path("/proc/self")], rights & (_WRITE_FILE | _TRUNCATE))
    _require(_libc().prctl(_NO_NEW_PRIVILEGES, 1, 0, 0, 0))
    _require(_call(_RESTRICT_SELF, ruleset, 0))
    os.close(ruleset)


def _allow(ruleset: int, paths: Iterable[Path], rights: int) -> None:
    for path in paths:
        try:
            descriptor = os.open(path, os.O_PATH | os.O_CLOEXEC)
        except FileNotFoundError:
            continue
        try:
            _require(_call(_ADD_RULE, ruleset, _PATH_BENEATH, struct.pack("=Qi", rights, descriptor), 0))
        finally:
            os.close(descriptor)


def _libc() -> ctypes.CDLL:
    return ctypes.CDLL(None, use_errno=True)


def _call(number: int, *arguments: bytes | int | None) -> int:
    return int(_libc().syscall(ctypes.c_long(number), *arguments))


def _require(result: int) -> int:
    """Return the result of a call of the system; raise an ``OSError`` if it has failed."""
    if result < 0:
        error = ctypes.get_errno()
        raise OSError(error, f"Landlock: {os.strerror(error)}")
    return result
