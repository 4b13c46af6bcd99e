"""What this machine has verified itself, so that `build` does not verify again what has not changed since.

The memory lies in the user's cache, one file for each thing that was verified. It is never read from a folder of
entries, which anybody may have written. The name of a file is the hash of all that the outcome rests on: the level, the
entry and the files that it names, this package with its checkpoints, extensions, and the versions of what computes.
"""

import os
import sys
from contextlib import suppress
from functools import cache
from hashlib import sha256
from pathlib import Path

from pydantic import ValidationError

import hhrl_agents
import hhrl_bench
import hhrl_envs
from hhrl_agents.atomic_files import write_atomically
from hhrl_agents.policies.checkpoint_file import SHIPPED
from hhrl_bench.evaluation.store import Store
from hhrl_bench.extensions import extension_hashes
from hhrl_bench.leaderboard.entry import entry_text, named_files
from hhrl_bench.leaderboard.level import Level
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.provenance import software
from hhrl_bench.publishing.publication import VerifiedRecord
from hhrl_envs.errors import InputError


def hash_of_all(path: Path, board: LeaderboardRecord, level: Level) -> str | None:
    """Return the hash of all that a verification of an entry, read from a path, rests on; None if a file is missing."""
    sha = sha256(f"{level};{_package()};{sorted(software().items())};{extension_hashes()};".encode())
    try:
        sha.update(entry_text(board).encode())
        for file in (path, *named_files(board, Store(path.parent))):
            sha.update(f"{file.name}:{sha256(file.read_bytes()).hexdigest()};".encode())
    except (OSError, InputError):
        return None
    return sha.hexdigest()


def recall(hashed: str | None) -> VerifiedRecord | None:
    """Return how far this machine has verified what has this hash; None if it has not."""
    try:
        return None if hashed is None else VerifiedRecord.model_validate_json(_path(hashed).read_bytes())
    except (OSError, RuntimeError, ValidationError):
        return None


def remember(hashed: str | None, path: Path, board: LeaderboardRecord, level: Level, verified: VerifiedRecord) -> None:
    """Keep how far an entry was verified that had a hash before; nothing if it has another one now, or has no place."""
    if hashed is None or hash_of_all(path, board, level) != hashed:
        return
    with suppress(OSError, RuntimeError, InputError):
        file = _path(hashed)
        write_atomically(file, verified.model_dump_json() + "\n")


def _path(hashed: str) -> Path:
    """Return the path of a file of the memory; raise a ``RuntimeError`` where the user has no home."""
    variable = "LOCALAPPDATA" if sys.platform == "win32" else "XDG_CACHE_HOME"
    return Path(os.environ.get(variable) or Path.home() / ".cache") / "hhrl-bench" / "verified" / f"{hashed}.json"


@cache
def _package() -> str:
    """Return the hash of all of this package's code, and of the checkpoints that come with it."""
    sha = sha256()
    folders = [Path(str(one.__file__)).parent for one in (hhrl_envs, hhrl_agents, hhrl_bench)]
    files = [path for folder in folders for path in sorted(folder.rglob("*.py"))]
    for path in (*files, *sorted(SHIPPED.rglob("*.safetensors"))):
        sha.update(f"{path.name}:{path.stat().st_size};".encode())
        sha.update(path.read_bytes())
    return sha.hexdigest()
