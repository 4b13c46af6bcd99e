"""Files and folders are written whole or not at all.

What a process that was killed has left of one is a *fragment*: a hidden file with a name of its own, which nothing
reads and which the next process that writes in the folder removes once it is old.
"""

import os
import re
import secrets
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from itertools import takewhile
from pathlib import Path
from tempfile import TemporaryDirectory

from hhrl_envs.errors import InputError

FRAGMENT_SECONDS = 3600.0
"""Age from which a fragment is no file that another process is writing now."""

_FRAGMENT = re.compile(r"\.(.+)\.[0-9a-f]{8}\.hhrl\.tmp", re.DOTALL)


class OutputError(InputError):
    """An output path that must not or cannot be written."""


def write_atomically(path: Path, content: str | bytes) -> None:
    """Write ``content`` to a temporary name in the same folder, then put it in the place of ``path``.

    The folder is made if need be. Content and name have reached the disk when this returns, so that no loss of power
    can leave half a file under the name.

    Raises:
        OutputError: if it cannot be written; what stood at ``path`` is then still there, and no folder is left.
    """
    _sweep(path.parent)
    temporary = _temporary(path)
    try:
        with made_folder(path.parent):
            _replace(path, temporary, content.encode() if isinstance(content, str) else content)
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror}") from error


def _replace(path: Path, temporary: Path, content: bytes) -> None:
    try:
        with temporary.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
        _sync_folder(path.parent)
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


def write_folder_atomically(path: Path, fill: Callable[[Path], None]) -> None:
    """Make a folder under a temporary name beside ``path``, let ``fill`` write into it, then give it its name.

    Raises:
        OutputError: if it cannot be written, or something stands at ``path`` already.
    """
    temporary = _temporary(path)
    try:
        with made_folder(path.parent):
            _sweep(path.parent)
            temporary.mkdir()
            fill(temporary)
            temporary.rename(path)
            _sync_folder(path.parent)
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror}") from error
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def require_writable(path: Path) -> None:
    """Check that a file can be written at ``path``, whose folder may yet have to be made; nothing is left there.

    Raises:
        OutputError: if it cannot, or ``path`` is something other than a file.
    """
    if path.exists() and not path.is_file():
        raise OutputError(f"cannot write {path}: it is not a file; name a file")
    probe = _temporary(path)
    try:
        with made_folder(path.parent):
            probe.touch()
            probe.unlink()
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror}; name another path") from error


@contextmanager
def made_folder(folder: Path) -> Iterator[None]:
    """Make a folder for this context; of those that had to be made, the ones that are empty at its end are removed."""
    missing = list(takewhile(lambda one: not one.exists(), (folder, *folder.parents)))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        yield
    finally:
        with suppress(OSError):  # it is not empty
            for one in missing:
                one.rmdir()


@contextmanager
def filled_folder(folder: Path) -> Iterator[Path]:
    """Return a context with a folder to write into; its files come into ``folder`` at its end, or not at all."""
    with made_folder(folder), TemporaryDirectory(prefix=".new-", dir=folder) as new:
        yield Path(new)
        for path in sorted(Path(new).iterdir()):
            path.replace(folder / path.name)


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
