"""The hash of the code: what can change the outcome of a unit changes it, and nothing else does."""

import shutil
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

import hhrl_agents
import hhrl_bench
import hhrl_envs
from hhrl_bench import extensions
from hhrl_bench.provenance import code_sha256, hash_code

PACKAGES = {one.__name__: Path(str(one.__file__)).parent for one in (hhrl_envs, hhrl_agents, hhrl_bench)}

HARMLESS = {
    "hhrl_envs.rendering": "draws what has happened",
    "hhrl_bench": "names what lies in the folders",
    "hhrl_bench.errors": "names errors",
    "hhrl_bench.extensions": "loads modules, whose own code is in the hash",
    "hhrl_bench.locks": "keeps processes out of each other's way",
    "hhrl_bench.provenance": "describes a result that is there",
    "hhrl_bench.text": "names files",
}
"""Modules that a unit imports and that cannot change what it comes to, and why not."""


@pytest.fixture(scope="module")
def copies(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, Path]:
    """Return copies of the packages' sources."""
    folder = tmp_path_factory.mktemp("packages")
    sources = shutil.ignore_patterns("*.safetensors", "__pycache__")
    return {name: shutil.copytree(path, folder / name, ignore=sources) for name, path in PACKAGES.items()}


def changes_hash(copies: Mapping[str, Path], module: str) -> bool:
    """Return whether a line more in a module is another hash."""
    package, _, rest = module.partition(".")
    path = copies[package].joinpath(*rest.split("."))
    path = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    before, text = hash_code(copies), path.read_text()
    path.write_text(text + "\n")
    try:
        return hash_code(copies) != before
    finally:
        path.write_text(text)


def test_a_copy_of_the_packages_has_the_same_hash(copies: Mapping[str, Path]) -> None:
    assert hash_code(copies) == code_sha256()


@pytest.mark.parametrize(
    "module",
    [
        "hhrl_envs.simulation.traffic",
        "hhrl_envs.simulation.engine.memory",
        "hhrl_envs.scenario.scenario",
        "hhrl_envs.views.parallel_env",
        "hhrl_envs.worlds.follow_v0",
        "hhrl_agents.networks.layers",
        "hhrl_agents.rules.rule_plus",
        "hhrl_bench.evaluation.metrics",
        "hhrl_bench.statistics.intervals",
        "hhrl_bench.tasks.tasks",
        "hhrl_bench.training.train",
    ],
)
def test_code_that_decides_is_in_the_hash(copies: Mapping[str, Path], module: str) -> None:
    assert changes_hash(copies, module)


@pytest.mark.parametrize(
    "module",
    [
        "hhrl_envs.rendering.picture",
        "hhrl_bench.figures.style",
        "hhrl_bench.tables.results",
        "hhrl_bench.cli.app",
        "hhrl_bench.publishing.publication",
        "hhrl_bench.leaderboard.entry",
        "hhrl_bench.execution.pools",
        "hhrl_bench.suites.suites",
        "hhrl_bench.transfer.metrics",
        "hhrl_bench.verification.verify",
    ],
)
def test_code_that_shows_or_hands_out_is_not(copies: Mapping[str, Path], module: str) -> None:
    assert not changes_hash(copies, module)


def test_a_new_file_below_a_folder_that_decides_changes_the_hash(copies: Mapping[str, Path]) -> None:
    before, new = hash_code(copies), copies["hhrl_envs"] / "simulation" / "engine" / "new.py"
    new.write_text("")
    assert hash_code(copies) != before
    new.unlink()
    assert hash_code(copies) == before


def test_the_numbers_that_rules_drive_by_are_in_the_hash(copies: Mapping[str, Path]) -> None:
    before, numbers = hash_code(copies), copies["hhrl_agents"] / "rules" / "rule-tuned.json"
    text = numbers.read_text()
    numbers.write_text(text + "\n")
    assert hash_code(copies) != before
    numbers.write_text(text)
    assert hash_code(copies) == before


def test_an_extension_is_in_the_hash(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, hashes = tmp_path / "of_mine.py", {code_sha256()}
    for value in (1, 2):
        path.write_text(f"VALUE = {value}\n")
        monkeypatch.setenv(extensions.VARIABLE, "")
        monkeypatch.setattr(extensions, "_hashes", {})
        extensions.load_extensions([str(path)])
        sys.modules.pop("of_mine")
        hashes.add(code_sha256())
    assert len(hashes) == 3


def test_all_that_a_unit_imports_is_in_the_hash_or_harmless(copies: Mapping[str, Path]) -> None:
    grimp = pytest.importorskip("grimp")
    graph = grimp.build_graph(*PACKAGES, cache_dir=None, exclude_type_checking_imports=True)
    found_by_name = {one for one in graph.modules if one.startswith(("hhrl_agents.", "hhrl_envs.worlds."))}
    starts = {"hhrl_bench.suites.units", *found_by_name}
    imported = {one for start in starts for one in graph.find_upstream_modules(start)} | starts
    unseen = {_harmless(one) for one in imported if not changes_hash(copies, one)}
    assert len(imported) > 80
    assert unseen == set(HARMLESS)


def _harmless(module: str) -> str:
    """Return the entry of HARMLESS that a module falls under, else its own name."""
    return "hhrl_envs.rendering" if module.startswith("hhrl_envs.rendering.") else module
