"""The page of the architecture names what is there, and the house keeps to its measures."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "architecture.md").read_text()
PACKAGES = {"hhrl_bench": ROOT, "hhrl_agents": ROOT / "agents", "hhrl_envs": ROOT / "environments"}
FOLDERS = [
    path
    for package, parent in PACKAGES.items()
    for path in (parent / package).rglob("*")
    if (path / "__init__.py").exists()
]
MODULES = [path for package, parent in PACKAGES.items() for path in (parent / package).rglob("*.py")]
WALKS = {
    "From an observation to a leaderboard number": 20,
    "From a transition to a checkpoint": 12,
    "From a suite to an entry": 20,
}


def name_of(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


@pytest.mark.parametrize("folder", FOLDERS, ids=name_of)
def test_a_folder_is_described_and_is_no_heap(folder: Path) -> None:
    assert re.search(rf"\*\*{folder.name}\*\*", PAGE)
    assert len(list(folder.glob("*.py"))) <= 20


@pytest.mark.parametrize("title", WALKS)
def test_a_walk_is_short_and_passes_modules_that_are_there(title: str) -> None:
    walk = PAGE.split(f"### {title}\n")[1].split("\n### ")[0]
    passed = re.findall(r"`(hhrl_\w+)/([\w/]+\.py)`", walk)
    assert [path for package, path in passed if not (PACKAGES[package] / package / path).exists()] == []
    assert 0 < len(set(passed)) <= WALKS[title]


@pytest.mark.parametrize("module", MODULES, ids=name_of)
def test_modules_and_functions_can_be_seen_at_a_glance(module: Path) -> None:
    text = module.read_text()
    assert text.count("\n") <= 400
    functions = [one for one in ast.walk(ast.parse(text)) if isinstance(one, ast.FunctionDef)]
    assert [one.name for one in functions if (one.end_lineno or 0) - one.lineno >= 60] == []
