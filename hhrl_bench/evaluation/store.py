"""A store: the evidence and the checkpoints of scored policies, each file named by the sha256 of its content.

A name that is a hash cannot lead out of the folder, says whether the file is whole, and is the same wherever the same
policy is published twice. Evidence is gzipped, but named by what it unpacks to, as libraries compress differently.
"""

import gzip
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hhrl_agents.atomic_files import write_atomically
from hhrl_agents.policies.checkpoint_file import CheckpointError, read_metadata
from hhrl_bench.errors import RecordError
from hhrl_bench.schema import sha256_of

MAX_BYTES = 32 * 2**20
"""No file of a store is larger."""

MAX_UNPACKED_BYTES = 2**26
"""No evidence is larger, once it is unpacked."""


@dataclass(frozen=True, slots=True)
class Store:
    """The store in a folder, which is made when something is added."""

    folder: Path

    def evidence(self, sha256: str) -> Path:
        """Return the path of a policy's evidence; see :mod:`hhrl_bench.evaluation.evidence`."""
        return self.folder / "evidence" / f"{sha256}.safetensors.gz"

    def checkpoint(self, sha256: str) -> Path:
        """Return the path of a checkpoint."""
        return self.folder / "checkpoints" / f"{sha256}.safetensors"

    def checkpoint_metadata(self, sha256: str) -> dict[str, Any]:
        """Return the metadata of a checkpoint.

        Raises:
            RecordError: see :func:`read`; or it is no checkpoint of this package.
        """
        path = self.checkpoint(sha256)
        read(path)
        try:
            return read_metadata(path)
        except CheckpointError as error:
            raise RecordError(f"{path} is no checkpoint of this package: {error}") from error

    def add_evidence(self, data: bytes) -> str:
        """Return the sha256 under which the content is kept."""
        return _add(self.evidence(sha256_of(data)), data, gzip.compress(data, mtime=0))

    def add_checkpoint(self, data: bytes) -> str:
        """Return the sha256 under which the content is kept."""
        return _add(self.checkpoint(sha256_of(data)), data, data)

    def copy(self, path: Path) -> None:
        """Add a file of another store.

        Raises:
            RecordError: see :func:`read`.
        """
        add = self.add_evidence if path.suffix == ".gz" else self.add_checkpoint
        add(read(path))


def read(path: Path, limit: int = MAX_UNPACKED_BYTES) -> bytes:
    """Return the content of a file of a store, unpacked, of at most ``limit`` bytes and MAX_UNPACKED_BYTES.

    Raises:
        RecordError: if there is none, it is larger than 32 MiB, it cannot be unpacked, or is not what its name says.
    """
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise RecordError(f"cannot read {path}: {error.strerror}") from error
    if len(data) > MAX_BYTES:
        raise RecordError(f"{path} is larger than {MAX_BYTES // 2**20} MiB, which no file of a store is")
    content = _unpacked(data, path, min(limit, MAX_UNPACKED_BYTES)) if path.suffix == ".gz" else data
    if sha256_of(content) != path.name.split(".")[0]:
        raise RecordError(f"{path} has been changed: the sha256 of what it holds is {sha256_of(content)}")
    return content


def _unpacked(data: bytes, path: Path, limit: int) -> bytes:
    """Return what one gzip stream holds, of at most ``limit`` bytes."""
    inflater = zlib.decompressobj(zlib.MAX_WBITS | 16)
    try:
        content = inflater.decompress(data, limit)
    except zlib.error as error:
        raise RecordError(f"{path} has been changed: it cannot be unpacked, {error}") from error
    if not inflater.eof or inflater.unused_data:
        raise RecordError(f"{path} has been changed: it is not one gzip stream of at most {limit:,} bytes, to its end")
    return content


def _add(path: Path, content: bytes, data: bytes) -> str:
    """Write ``data``, which holds ``content``, unless the file holds that already; return the hash in its name."""
    if not _holds(path, content):
        write_atomically(path, data)
    return path.name.split(".")[0]


def _holds(path: Path, content: bytes) -> bool:
    try:
        return read(path) == content
    except RecordError:
        return False
