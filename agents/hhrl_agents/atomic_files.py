"""Files are written whole or not at all."""

import os
from pathlib import Path

from hhrl_envs.errors import InputError


class OutputError(InputError):
    """An output path that must not or cannot be written."""


def write_atomically(path: Path, content: str | bytes) -> None:
    """Write ``content`` to a temporary name in the same folder, then put it in the place of ``path``.

    Raises:
        OutputError: if it cannot be written; what stood at ``path`` is then still there.
    """
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        temporary.write_bytes(content.encode() if isinstance(content, str) else content)
        temporary.replace(path)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        raise OutputError(f"cannot write {path}: {error.strerror}") from error


def require_writable(path: Path) -> None:
    """Make the folder of ``path`` and check that a file can be written there.

    Raises:
        OutputError: if it cannot, or ``path`` is something other than a file.
    """
    if path.exists() and not path.is_file():
        raise OutputError(f"cannot write {path}: it is not a file; name a file")
    probe = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror}; name another path") from error
