"""The standard streams: whatever a process was begun with, they can be read and written."""

import os
import sys
from contextlib import suppress
from io import TextIOWrapper
from typing import cast

_MODES = {"stdin": "r", "stdout": "w", "stderr": "w"}


def mend_streams() -> None:
    """Put the null device in the place of closed streams, and let signs be replaced that an encoding lacks.

    The descriptors 0 to 2 are taken too: else the next file that is opened would get one of them, and what a library or
    a process of ours prints would be written into it.
    """
    for number, (name, mode) in enumerate(_MODES.items()):
        stream = cast(TextIOWrapper | None, getattr(sys, name))
        if stream is None:
            _occupy(number)
            null = open(os.devnull, mode, encoding="utf-8")  # noqa: SIM115, PTH123 - it lasts as long as the process
            stream = cast(TextIOWrapper, null)
            setattr(sys, name, stream)
        if mode == "w" and isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")


def _occupy(number: int) -> None:
    """Open the null device as a descriptor that is closed."""
    with suppress(OSError):
        os.fstat(number)
        return
    descriptor = os.open(os.devnull, os.O_RDWR)
    os.dup2(descriptor, number)
    if descriptor != number:
        os.close(descriptor)
