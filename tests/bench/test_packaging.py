"""The distribution: what its metadata promises holds of the tested versions and of the folders."""

import tomllib
from pathlib import Path
from typing import Any

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2]
PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
UNTESTED = {"ray"}


def requirements() -> list[Requirement]:
    extras = PROJECT["optional-dependencies"]
    lines = [*PROJECT["dependencies"], *(line for extra in extras.values() for line in extra)]
    return [requirement for requirement in map(Requirement, lines) if requirement.name != PROJECT["name"]]


def constraints() -> dict[str, str]:
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    pairs = (line.split("==") for line in lines if line and not line.startswith("#"))
    return {canonicalize_name(name): version for name, version in pairs}


@pytest.mark.parametrize("requirement", requirements(), ids=str)
def test_tested_version_satisfies_the_requirement(requirement: Requirement) -> None:
    if requirement.name not in UNTESTED:
        assert constraints()[canonicalize_name(requirement.name)] in requirement.specifier


def test_extras_and_dependencies_never_bring_torch_uninvited() -> None:
    assert not {"torch", "pygame-ce", "matplotlib"} & {Requirement(line).name for line in PROJECT["dependencies"]}


def test_folders_of_packages_are_not_packages() -> None:
    assert not [*(ROOT / "environments").glob("*.py"), *(ROOT / "agents").glob("*.py")]


@pytest.mark.parametrize("package", ["hhrl_bench", "environments/hhrl_envs", "agents/hhrl_agents"])
def test_packages_are_typed(package: str) -> None:
    assert (ROOT / package / "py.typed").is_file()
