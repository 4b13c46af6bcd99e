"""The distribution: what its metadata promises holds of the tested versions and of the folders."""

import json
import os
import re
import subprocess
import sys
import tarfile
from pathlib import Path
from zipfile import ZipFile

import pytest
from hatchling.builders.sdist import SdistBuilder
from hatchling.builders.wheel import WheelBuilder
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from support.distribution import PROJECT, ROOT, constraints, dependencies

UNTESTED = {"wandb", "mlflow"}  # beside these versions; make interop tests them beside others
PACKAGES = ("hhrl_bench", "environments/hhrl_envs", "agents/hhrl_agents")


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder that the wheel of this tree unpacks into."""
    folder = tmp_path_factory.mktemp("wheel")
    (wheel,) = WheelBuilder(str(ROOT)).build(directory=str(folder), versions=["standard"])
    with ZipFile(wheel) as archive:
        archive.extractall(folder / "installed")
    return folder / "installed"


@pytest.mark.parametrize(
    "requirement",
    sorted((one for one in set(dependencies(*PROJECT["optional-dependencies"])) if one.name not in UNTESTED), key=str),
    ids=str,
)
def test_tested_version_satisfies_the_requirement(requirement: Requirement) -> None:
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


def test_the_source_distribution_is_small_and_has_no_published_data(tmp_path: Path) -> None:
    (made,) = SdistBuilder(str(ROOT)).build(directory=str(tmp_path))
    assert Path(made).stat().st_size < 3_000_000
    with tarfile.open(made) as archive:
        folders = {name.split("/")[1] for name in archive.getnames()}
    assert "leaderboards" not in folders
    assert {"agents", "environments", "hhrl_bench", "tests", "locks", "Makefile", "pyproject.toml"} <= folders


def test_classifiers_name_the_tested_python() -> None:
    assert "Programming Language :: Python :: 3.11" in PROJECT["classifiers"]


def test_no_hint_names_a_package_of_an_index() -> None:
    sources = [path for package in PACKAGES for path in (ROOT / package).rglob("*.py")]
    pages = [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"), *ROOT.glob("*/README.md")]
    for path in [*sources, *pages]:
        assert not re.search(r"pip install[^\n]*[ '\"]hhrl-bench", path.read_text()), path
