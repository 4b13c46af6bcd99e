"""Frames: what the harness and an agent in a process of its own write to each other; reading them runs no code.

The first request is a text, every other one a call with its arrays. An answer is a status and bytes, as many as the
call gives. Integers and arrays are little-endian, arrays one after the other without a header: the call fixes their
types, the request the numbers of rows and columns.
"""

import struct
from collections.abc import Mapping, Sequence
from math import prod
from typing import Any, BinaryIO, NamedTuple

import numpy as np
from numpy.typing import NDArray

LONGEST_TEXT = 1 << 16
"""Most bytes of a text that an agent's process answers."""

DONE, FAILED = 0, 1
"""Statuses of answers: what the call gives follows, or a text that says what is wrong."""

REQUEST = struct.Struct("<BII")
"""A request's head: the call's number, rows, columns."""

ANSWER = struct.Struct("<BI")
"""An answer's head: status, bytes that follow."""

_TEXT = struct.Struct("<I")


class Column(NamedTuple):
    """An array [rows], or [rows, columns] if it is ``wide``."""

    dtype: np.dtype[Any]
    wide: bool = False

    def shape(self, rows: int, columns: int) -> tuple[int, ...]:
        """Return the shape of the array."""
        return (rows, columns) if self.wide else (rows,)


class Call(NamedTuple):
    """A method of an agent: what it takes, the first array saying how many rows there are, and what it gives."""

    number: int
    takes: Sequence[Column]
    gives: Sequence[Column]


_FLAGS, _CHOICES = Column(np.dtype(np.bool_)), Column(np.dtype("<i8"))
_VECTORS = Column(np.dtype("<f4"), wide=True)

CALLS: Mapping[str, Call] = {
    "reset": Call(0, (_FLAGS,), ()),
    "act": Call(1, (_VECTORS,), (_CHOICES, _CHOICES)),
    "act_with_option": Call(2, (_VECTORS, _CHOICES), (_CHOICES,)),
    "attention": Call(3, (_VECTORS, _CHOICES), (_VECTORS,)),
}
"""The methods of agents that can be called, by their names."""

ABILITIES = ("act_with_option", "attention")
"""Those that an agent need not have."""


def numbered(number: int) -> tuple[str, Call]:
    """Return the name and the call of this number."""
    return next((name, call) for name, call in CALLS.items() if call.number == number)


def size(columns: Sequence[Column], rows: int, width: int) -> int:
    """Return the bytes of arrays with so many rows and columns."""
    return sum(one.dtype.itemsize * prod(one.shape(rows, width)) for one in columns)


def pack(columns: Sequence[Column], arrays: Sequence[NDArray[Any]], rows: int, width: int) -> bytes:
    """Return the arrays as bytes; raise a ``ValueError`` if one does not have the shape of its column."""
    parts = zip(columns, arrays, strict=True)
    return b"".join(np.asarray(array, one.dtype).reshape(one.shape(rows, width)).tobytes() for one, array in parts)


def unpack(columns: Sequence[Column], data: bytearray, rows: int, width: int) -> list[NDArray[Any]]:
    """Return the arrays in bytes of the right ``size``; they can be written to."""
    arrays, offset = [], 0
    for one in columns:
        shape = one.shape(rows, width)
        arrays.append(np.frombuffer(data, one.dtype, prod(shape), offset).reshape(shape))
        offset += arrays[-1].nbytes
    return arrays


def request(call: Call, arrays: Sequence[NDArray[Any]]) -> tuple[bytes, int, int]:
    """Return a request as bytes, and its rows and columns."""
    first = np.asarray(arrays[0])
    rows, width = len(first), first.shape[1] if first.ndim > 1 else 0
    return REQUEST.pack(call.number, rows, width) + pack(call.takes, arrays, rows, width), rows, width


def text_request(text: str) -> bytes:
    """Return the first request as bytes."""
    return _TEXT.pack(len(text.encode())) + text.encode()


def answer(data: bytes) -> bytes:
    """Return the answer that holds what a call gives."""
    return ANSWER.pack(DONE, len(data)) + data


def failure(text: str) -> bytes:
    """Return the answer that says what is wrong; a text that is too long is cut off."""
    data = text.encode(errors="replace")[:LONGEST_TEXT]
    return ANSWER.pack(FAILED, len(data)) + data


def read_text(stream: BinaryIO) -> str:
    """Return the text of the first request."""
    (length,) = _TEXT.unpack(read_exactly(stream, _TEXT.size))
    return read_exactly(stream, length).decode()


def read_exactly(stream: BinaryIO, length: int) -> bytearray:
    """Return that many bytes of a stream, however they come.

    Raises:
        EOFError: if the stream ends before.
    """
    data = bytearray(length)
    view, place = memoryview(data), 0
    while place < length:
        count = stream.readinto(view[place:])  # type: ignore[attr-defined]
        if not count:
            raise EOFError
        place += count
    return data
