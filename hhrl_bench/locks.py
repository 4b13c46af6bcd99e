"""Locks of files, which the system releases when their holder ends, however that ends."""

import errno
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from filelock import FileLock, Timeout

from hhrl_agents.atomic_files import OutputError

_NO_LOCKS = {errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.EINVAL}


@contextmanager
def locked(path: Path, busy: str, patience: float, *, passing: bool = False) -> Iterator[None]:
    """Hold the lock of a file in this context; the system releases it when this process ends, however it ends.

    On a file system without locks nothing is held. A ``passing`` lock leaves no file behind; filelock lets who waited
    for the file that is gone ask for a new one.

    Raises:
        OutputError: ``busy``, if another process holds it for more than ``patience`` seconds; or it cannot be written.
    """
    if path.exists() and not path.is_file():
        raise OutputError(f"cannot lock {path}: it is not a file; remove it")
    lock = FileLock(path, timeout=patience)
    try:
        lock.acquire()
    except Timeout as error:
        raise OutputError(busy) from error
    except OSError as error:
        if error.errno not in _NO_LOCKS:
            raise OutputError(f"cannot write {path}: {error.strerror}") from error
    try:
        yield
    finally:
        if passing:
            with suppress(OSError):  # Windows removes no file that is open
                path.unlink()
        lock.release()
