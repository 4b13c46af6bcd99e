"""Files and folders are written whole or not at all.

What a process that was killed has left of one is a *fragment*: a hidden file with a name of its own, which nothing
reads and which the next process that writes in the folder removes once it is old.
"""

import re
import secrets
import shutil
import time
from collections.abc import Callable
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

    Raises:
        OutputError: if it cannot be written; what stood at ``path`` is then still there.
    """
    _sweep(path.parent)
    temporary = _temporary(path)
    try:
        temporary.write_bytes(content.encode() if isinstance(content, str) else content)
        temporary.replace(path)
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror}") from error
    finally:
        with suppress(OSError):
            temporary.unlink()  # there is none any more unless it could not be written, or an interrupt came


def write_folder_atomically(path: Path, fill: Callable[[Path], None]) -> None:
    """Make a folder under a temporary name beside ``path``, let ``fill`` write into it, then give it its name.

    Raises:
        OutputError: if it cannot be written, or something stands at ``path`` already.
    """
    temporary = _temporary(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        _sweep(path.parent)
        temporary.mkdir()
        fill(temporary)
        temporary.rename(path)
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror}") from error
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


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
                _remove(path)


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink()


def _temporary(path: Path) -> Path:
    """Return a path that no other write, by any process of any machine, has."""
    return path.with_name(f".{path.name}.{secrets.token_hex(4)}.hhrl.tmp")


@cache
def _sweep(folder: Path) -> None:
    """Remove the old fragments in a folder, once a process."""
    remove_fragments(folder, older_than=FRAGMENT_SECONDS)
