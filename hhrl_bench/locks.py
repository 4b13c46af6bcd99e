"""Locks on files: the system lets go of one when its holder ends, however it ends, so that none is ever stale."""

import errno
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from hhrl_agents.atomic_files import OutputError

if sys.platform != "win32":
    import fcntl

INTERVAL = 0.05
_NO_LOCKS = {errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.EINVAL}


@contextmanager
def locked(path: Path, busy: str, *, shared: bool = False, patience: float = 1.0) -> Iterator[None]:
    """Return a context that holds the lock of the file at ``path``, which is made where it is not.

    ``shared``: beside others that share it. On a file system without locks, and on Windows, nothing is held.

    Raises:
        OutputError: ``busy``, if others hold it for more than ``patience`` seconds; or the file cannot be written.
    """
    until = time.monotonic() + patience
    with _open(path) as file:
        while not _take(file, shared=shared):
            if time.monotonic() >= until:
                raise OutputError(busy)
            time.sleep(INTERVAL)
        yield


def is_locked(path: Path) -> bool:
    """Return whether somebody holds the lock of the file at ``path``, if it is one."""
    try:
        if not path.is_file():
            return False
        with path.open("rb") as file:
            return not _take(file, shared=True)
    except OSError:
        return False


def _open(path: Path) -> IO[bytes]:
    if path.exists() and not path.is_file():
        raise OutputError(f"cannot lock {path}: it is not a file; remove it")
    try:
        return path.open("ab")
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror}") from error


def _take(file: IO[bytes], *, shared: bool) -> bool:
    if sys.platform == "win32":
        return True
    try:
        fcntl.flock(file, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError as error:
        if error.errno not in _NO_LOCKS:
            raise
    return True
