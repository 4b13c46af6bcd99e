"""Files are written whole or not at all.

What a process that was killed has left of one is a *fragment*: a hidden file with a name of its own, which nothing
reads and which the next process that writes in the folder removes once it is old.
"""

import os
import re
import secrets
import time
from contextlib import suppress
from functools import cache
from pathlib import Path

from hhrl_envs.errors import InputError

FRAGMENT_SECONDS = 3600.0
"""Age from which a fragment is no file that another process is writing now."""

_FRAGMENT = re.compile(r"\.(.+)\.[0-9a-f]{8}\.hhrl\.tmp", re.DOTALL)


class OutputError(InputError):
    """An output path that must not or cannot be written."""


def write_atomically(path: Path, content: str | bytes) -> None:
    """Write ``content`` to a temporary name in the same folder, then put it in the place of ``path``.

    Both have reached the disk when this returns, so that no loss of power can leave half a file under the name.

    Raises:
        OutputError: if it cannot be written; what stood at ``path`` is then still there.
    """
    _sweep(path.parent)
    temporary = _temporary(path)
    try:
        with temporary.open("wb") as file:
            file.write(content.encode() if isinstance(content, str) else content)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
        _sync_folder(path.parent)
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror}") from error
    finally:
        with suppress(OSError):
            temporary.unlink()  # there is none any more unless it could not be written, or an interrupt came


def _sync_folder(folder: Path) -> None:
    """Let the disk know the names in a folder, where a system lets one open folders."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def require_writable(path: Path) -> None:
    """Make the folder of ``path`` and check that a file can be written there.

    Raises:
        OutputError: if it cannot, or ``path`` is something other than a file.
    """
    if path.exists() and not path.is_file():
        raise OutputError(f"cannot write {path}: it is not a file; name a file")
    probe = _temporary(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror}; name another path") from error


def is_fragment(path: Path) -> bool:
    """Return whether a path is that of a file that is being written, or that a kill has left half written."""
    return _FRAGMENT.fullmatch(path.name) is not None


def remove_fragments(folder: Path, *, of: str | None = None, older_than: float = 0.0) -> None:
    """Remove the fragments in a folder, of the file called ``of`` or of all, that are older than so many seconds.

    Younger than ``FRAGMENT_SECONDS`` they may only be removed by who knows that no other process writes these files.
    """
    before = time.time() - older_than
    with suppress(OSError):
        for path in folder.iterdir():
            match = _FRAGMENT.fullmatch(path.name)
            if match and of in {None, match[1]} and path.stat().st_mtime <= before:
                path.unlink()


def _temporary(path: Path) -> Path:
    """Return a path that no other write, by any process of any machine, has."""
    return path.with_name(f".{path.name}.{secrets.token_hex(4)}.hhrl.tmp")


@cache
def _sweep(folder: Path) -> None:
    """Remove the old fragments in a folder, once a process."""
    remove_fragments(folder, older_than=FRAGMENT_SECONDS)
