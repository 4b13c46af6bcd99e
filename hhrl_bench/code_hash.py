"""The hash of the code that makes results."""

import hashlib
from functools import cache
from pathlib import Path

import hhrl_agents
import hhrl_bench
import hhrl_envs


@cache
def code_sha256() -> str:
    """Return the sha256, in hex, of all Python files of the three packages: where it is another, results may be too."""
    sha = hashlib.sha256()
    for package in (hhrl_envs, hhrl_agents, hhrl_bench):
        folder = Path(str(package.__file__)).parent
        for path in sorted(folder.rglob("*.py")):
            sha.update(f"{package.__name__}/{path.relative_to(folder).as_posix()}:{path.stat().st_size};".encode())
            sha.update(path.read_bytes())
    return sha.hexdigest()
