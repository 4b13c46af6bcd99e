"""The file of a checkpoint, read without the networks: its place among the shipped ones, and its metadata.

A checkpoint is one safetensors file, of which nothing can execute code. Its header holds the metadata as one JSON
object, so that the same agent gives the same bytes.
"""

import json
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from safetensors import SafetensorError, safe_open

from hhrl_envs.errors import InputError

SHIPPED = Path(__file__).parents[1] / "trained"
"""The folder of the trained policies that come with the package: a folder for each method, a file for each seed."""

METADATA_KEY = "hhrl-checkpoint"
"""Where in a header the metadata are."""

MAX_HEADER_BYTES = 2**16
"""No header of a checkpoint is longer: it names some arrays, and says of a training what takes a page."""


class CheckpointError(InputError):
    """A checkpoint that is missing, damaged, foreign or of another interface."""


def read_metadata(checkpoint: Path | bytes) -> dict[str, Any]:
    """Return the metadata of a checkpoint, given its path or its content.

    Only that it is a whole safetensors file of this package is checked, not what the metadata say.

    Raises:
        CheckpointError: if it is not.
    """
    if isinstance(checkpoint, bytes):
        with TemporaryDirectory() as folder:  # safetensors reads metadata from files alone
            path = Path(folder) / "checkpoint.safetensors"
            path.write_bytes(checkpoint)
            return read_metadata(path)
    try:
        _require_short_header(checkpoint)
        with safe_open(checkpoint, framework="np") as file:
            header = file.metadata() or {}
    except (SafetensorError, OSError) as error:
        raise CheckpointError(
            f"not a whole safetensors file ({error}); name one that hhrl-bench train has written"
        ) from error
    if METADATA_KEY not in header:
        raise CheckpointError("a safetensors file, but none that this package has written")
    try:
        return dict(json.loads(header[METADATA_KEY]))
    except (TypeError, ValueError, RecursionError) as error:
        raise CheckpointError(f"its metadata are no JSON object: {error}") from error


def _require_short_header(path: Path) -> None:
    with path.open("rb") as file:
        length = int.from_bytes(file.read(8), "little")
    if length > MAX_HEADER_BYTES:
        raise CheckpointError(f"its header says that it has {length:,} bytes; a checkpoint's has {MAX_HEADER_BYTES:,}")
