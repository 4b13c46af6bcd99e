"""Sweeps driven from outside, as processes: begun, killed, resumed, and what they have left compared."""

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from hhrl_agents.atomic_files import is_fragment

TESTS = Path(__file__).parents[1]


def environment(**more: str) -> dict[str, str]:
    """Return the environment of a process that finds what this one finds."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join([str(TESTS), *filter(None, sys.path)]), **more}


def command(suite: str, folder: Path, *options: str) -> list[str]:
    """Return the command that runs one of the suites of :mod:`support.sweeping` in a folder."""
    paths = ["--out", str(folder / "out" / f"{suite}.json"), "--work", str(folder / "work")]
    return [sys.executable, "-m", "support.sweeping", "run", "--suite", suite, *paths, *options]


def start(suite: str, folder: Path, *options: str, **more: Any) -> subprocess.Popen[str]:
    """Return the process that runs a suite."""
    usual = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "env": environment()}
    return subprocess.Popen(command(suite, folder, *options), **{**usual, **more})


def finish(suite: str, folder: Path, *options: str, **more: Any) -> tuple[int, str]:
    """Return the exit code of a run that is not disturbed, and what it said on stderr."""
    with start(suite, folder, *options, **more) as process:
        _, said = process.communicate()
    return process.returncode, said


def results(folder: Path) -> dict[str, Any]:
    """Return every file that is a result, by name: JSON and lines without clocks, the rest as bytes."""
    found = [path for path in folder.rglob("*") if path.is_file() and path.parent.name != "progress"]
    return {str(path.relative_to(folder)): _content(path) for path in found if not _is_told_by_clock(path)}


def outcomes(folder: Path) -> dict[Path, int]:
    """Return the outcome files that there are, each whole, with the times at which they were written."""
    paths = sorted((folder / "work").rglob("result-*.json"))
    for path in paths:
        json.loads(path.read_text())
    return {path: path.stat().st_mtime_ns for path in paths}


def workers_of(group: int) -> list[bytes]:
    """Return the commands of the worker processes of a process group."""
    commands = []
    for process in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            if os.getpgid(int(process.name)) == group:
                commands.append((process / "cmdline").read_bytes())
    return [command for command in commands if b"spawn_main" in command]


def _is_told_by_clock(path: Path) -> bool:
    return path.name.startswith("provenance") or is_fragment(path)


def _content(path: Path) -> Any:
    if path.suffix != ".json":
        return path.read_bytes()
    return _without_clocks(json.loads(path.read_text()))


def _without_clocks(data: Any) -> Any:
    if isinstance(data, Mapping):
        return {key: _without_clocks(value) for key, value in data.items() if key not in {"seconds", "provenance"}}
    return data
