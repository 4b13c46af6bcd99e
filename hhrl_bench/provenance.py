"""Where numbers come from: the versions, the commit and the machine they were made with."""

import os
import platform
import subprocess
import sys
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import hhrl_bench
from hhrl_bench.code_hash import code_sha256
from hhrl_bench.records import HardwareRecord, ProvenanceRecord

PACKAGES = ("numpy", "numba", "scipy", "gymnasium", "pettingzoo", "torch", "safetensors", "pydantic")


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
