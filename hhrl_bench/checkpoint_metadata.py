"""The metadata of a checkpoint, read without torch."""

import json
from collections.abc import Mapping
from typing import Any

from hhrl_bench.errors import RecordError

_KEY = "hhrl-checkpoint"
_LENGTH = 8
_MAX_HEADER = 2**20


def read(data: bytes) -> Mapping[str, Any]:
    """Return the metadata in a checkpoint's content.

    A safetensors file begins with the length of its header, 8 bytes little-endian, and the header, which is JSON.

    Raises:
        RecordError: if there is none.
    """
    length = min(int.from_bytes(data[:_LENGTH], "little"), _MAX_HEADER)
    try:
        return dict(json.loads(json.loads(data[_LENGTH : _LENGTH + length])["__metadata__"][_KEY]))
    except (KeyError, TypeError, ValueError, RecursionError) as error:
        raise RecordError(f"no checkpoint of this package: {type(error).__name__} {error}") from error
