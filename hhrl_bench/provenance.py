"""Where numbers come from: the versions, the commit and the machine they were made with."""

import hashlib
import os
import platform
import subprocess
import sys
from collections.abc import Mapping
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Annotated

from pydantic import Field, StringConstraints

import hhrl_agents
import hhrl_bench
import hhrl_envs
from hhrl_bench.extensions import extension_hashes
from hhrl_bench.schema import Commit, Label, Name, Positive, Record, sha256_of

PACKAGES = ("numpy", "numba", "scipy", "gymnasium", "pettingzoo", "torch", "safetensors", "pydantic")


Moment = Annotated[str, StringConstraints(pattern=r"^[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9]{2}:[0-9]{2}:[0-9]{2}\+00:00$")]


class HardwareRecord(Record):
    """The machine, without its name."""

    processor: Label
    cores: Positive
    machine: Label
    system: Label


def git_commit(package: Path) -> str | None:
    """Return the commit of the checkout that ``package`` is the top-level folder of; None if it is not in one.

    The commit ends in ``-dirty`` where tracked files differ from it.
    """
    top = _git(package, "rev-parse", "--show-toplevel")
    if top is None or Path(top).resolve() != package.resolve().parent:
        return None
    commit = _git(package, "rev-parse", "HEAD")
    if commit is None:
        return None
    return commit + ("-dirty" if _git(package, "status", "--porcelain", "--untracked-files=no") else "")


class ProvenanceRecord(Record):
    """All that may differ between two runs of one command; ``wall_seconds`` are by task and agent."""

    command: Name
    executor: Name = "local"
    created: Moment
    wall_seconds: dict[Label, Annotated[float, Field(allow_inf_nan=False, ge=0.0)]]
    package_version: Name
    git_commit: Commit | None
    hardware: HardwareRecord
    versions: Annotated[dict[Name, Name], Field(max_length=100)]


def provenance(command: str, wall_seconds: Mapping[str, float], executor: str = "local") -> ProvenanceRecord:
    """Return the provenance of what ``command`` just made, stamped with the present time (UTC)."""
    return ProvenanceRecord(
        command=command,
        executor=executor,
        created=datetime.now(UTC).isoformat(timespec="seconds"),
        wall_seconds={key: round(seconds, 3) for key, seconds in wall_seconds.items()},
        package_version=hhrl_bench.__version__,
        git_commit=git_commit(Path(hhrl_bench.__file__).parent),
        hardware=_hardware(),
        versions=_versions(),
    )


def software() -> dict[str, str]:
    """Return what results may depend on: the hash of the code that makes them, and the versions of packages."""
    return {"the code of hhrl-bench": code_sha256()[:12], **_versions()}


def _git(folder: Path, *arguments: str) -> str | None:
    try:
        done = subprocess.run(
            ["git", "-C", str(folder), *arguments], capture_output=True, text=True, timeout=10, check=True
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip()


def _versions() -> dict[str, str]:
    found = {"python": platform.python_version()}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found


def _hardware() -> HardwareRecord:
    return HardwareRecord(
        processor=_processor(), cores=os.cpu_count() or 1, machine=platform.machine(), system=platform.system()
    )


def _processor() -> str:
    if sys.platform == "linux":
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


_DECISIVE: Mapping[str, tuple[str, ...]] = {
    "hhrl_envs": ("*.py", *(f"{folder}/**/*.py" for folder in ("scenario", "simulation", "views", "worlds"))),
    "hhrl_agents": ("**/*.py", "rules/*.json"),
    "hhrl_bench": (
        "schema.py",
        *(f"{folder}/**/*.py" for folder in ("evaluation", "isolation", "statistics", "tasks", "training")),
        "transfer/transfer.py",
        "suites/units.py",
    ),
}


def code_sha256() -> str:
    """Return the sha256, in hex, of the code that decides what a unit comes to: our own, and loaded extensions.

    See :func:`hash_code` for what of our own code that is.
    """
    own, extensions = _own_code_sha256(), extension_hashes()
    return sha256_of("".join([own, *extensions]).encode()) if extensions else own


@cache
def _own_code_sha256() -> str:
    return hash_code({one.__name__: Path(str(one.__file__)).parent for one in (hhrl_envs, hhrl_agents, hhrl_bench)})


def hash_code(packages: Mapping[str, Path]) -> str:
    """Return the sha256, in hex, of the decisive files of the packages in these folders.

    A result is made again where this hash has changed. In it are the scenarios, the simulator and its views, in one of
    which PPO learns; all agents and learners, with the numbers that rules drive by; and of the harness what evaluates,
    trains, reuses, counts and keeps. Not in it is what draws pictures, what works on finished results, as leaderboards,
    tables and figures do, and what hands out or shows the work, as executors and the command line do.
    """
    sha = hashlib.sha256()
    for name, folder in packages.items():
        paths = {path for pattern in _DECISIVE[name] for path in folder.glob(pattern)}
        for path in sorted(paths, key=lambda one: one.relative_to(folder).as_posix()):
            sha.update(f"{name}/{path.relative_to(folder).as_posix()}:{path.stat().st_size};".encode())
            sha.update(path.read_bytes())
    return sha.hexdigest()
