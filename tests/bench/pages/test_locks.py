"""What the Makefile installs is pinned and hashed, and follows from pyproject.toml and constraints.txt."""

import re
from pathlib import Path

import pytest
from packaging.utils import canonicalize_name

from support.distribution import PROJECT, ROOT, constraints, dependencies

LOCKS = ROOT / "locks"
ENTRY = re.compile(r"(?P<name>[a-z0-9-]+)==(?P<version>[^ ;]+)[^\\]*\\\n(?: {4}--hash=sha256:[0-9a-f]{64}(?: \\)?\n)+")


def locked(path: Path) -> dict[str, str]:
    return {entry["name"]: entry["version"] for entry in ENTRY.finditer(path.read_text())}


@pytest.mark.parametrize("lock", sorted(LOCKS.glob("*.txt")), ids=lambda lock: lock.stem)
def test_every_line_of_a_lock_is_a_pin_with_hashes(lock: Path) -> None:
    text = re.sub(r"^#.*\n", "", lock.read_text(), flags=re.MULTILINE)
    assert locked(lock)
    assert ENTRY.sub("", text) == ""


@pytest.mark.parametrize(("lock", "extras"), [("bare", ()), ("all", ("all",)), ("dev", ("dev",))])
def test_a_lock_has_the_tested_version_of_all_that_is_asked_for(lock: str, extras: tuple[str, ...]) -> None:
    found = locked(LOCKS / f"{lock}.txt")
    tested = constraints()
    assert found == {name: tested[name] for name in found}, "run: make locks"
    with_torch = {**found, **locked(LOCKS / "torch.txt")}
    asked_for = {canonicalize_name(requirement.name) for requirement in dependencies(*extras)}
    assert asked_for <= with_torch.keys(), "run: make locks"


def test_both_builds_of_torch_are_the_tested_version() -> None:
    assert locked(LOCKS / "torch.txt")["torch"] == constraints()["torch"]
    assert locked(LOCKS / "torch-cpu.txt") == {"torch": constraints()["torch"] + "+cpu"}


def test_what_builds_the_project_is_locked_with_it() -> None:
    assert {"hatchling", "editables"} <= locked(LOCKS / "bare.txt").keys()
    assert PROJECT["name"] not in locked(LOCKS / "dev.txt")
