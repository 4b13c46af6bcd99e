"""The distribution: what its metadata promises holds of the tested versions and of the folders."""

import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import pytest
from hatchling.builders.wheel import WheelBuilder
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[3]
PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
UNTESTED = {"ray", "wandb", "mlflow"}  # beside these versions; make interop tests them beside others
PACKAGES = ("hhrl_bench", "environments/hhrl_envs", "agents/hhrl_agents")


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder that the wheel of this tree unpacks into."""
    folder = tmp_path_factory.mktemp("wheel")
    (wheel,) = WheelBuilder(str(ROOT)).build(directory=str(folder), versions=["standard"])
    with ZipFile(wheel) as archive:
        archive.extractall(folder / "installed")
    return folder / "installed"


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


@pytest.mark.parametrize("package", PACKAGES)
def test_packages_are_typed(package: str) -> None:
    assert (ROOT / package / "py.typed").is_file()


@pytest.mark.parametrize("package", PACKAGES)
def test_the_wheel_holds_every_file_of_a_package(package: str, installed: Path) -> None:
    source, found = ROOT / package, installed / Path(package).name
    files = [
        path.relative_to(source) for path in source.rglob("*") if path.is_file() and "__pycache__" not in path.parts
    ]
    assert files
    for file in files:
        assert (found / file).read_bytes() == (source / file).read_bytes()


def test_the_wheel_alone_lists_its_trained_agents(installed: Path, tmp_path: Path) -> None:
    alone = {**os.environ, "PYTHONPATH": str(installed)}
    code = "import hhrl_agents, hhrl_bench.cli; print(hhrl_agents.__file__); hhrl_bench.cli.main()"
    command = [sys.executable, "-c", code, "list", "agents", "--json"]
    printed = subprocess.run(command, env=alone, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    place, _, listed = printed.partition("\n")
    assert Path(place).is_relative_to(installed)
    shipped = {agent["id"]: agent["shipped_seeds"] for agent in json.loads(listed) if agent["shipped_seeds"]}
    assert shipped == {
        folder.name: len(list(folder.glob("*.safetensors")))
        for folder in (ROOT / "agents/hhrl_agents/trained").iterdir()
    }
