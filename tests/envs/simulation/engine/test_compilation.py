"""Kernels are compiled anew when any of the sources that they come from has changed."""

import shutil
from pathlib import Path

import pytest

import hhrl_envs
from hhrl_envs.simulation.engine.compilation import digest_sources

PACKAGE = Path(hhrl_envs.__file__).parent


@pytest.fixture
def copied(tmp_path: Path) -> Path:
    return Path(shutil.copytree(PACKAGE, tmp_path / "hhrl_envs", ignore=shutil.ignore_patterns("__pycache__")))


@pytest.mark.parametrize(
    "changed",
    [
        "sub_goals.py",
        "scenario/profiles.py",
        "simulation/dynamics.py",
        "simulation/sub_goal_kernels.py",
        "simulation/engine/layout.py",
    ],
)
def test_a_changed_source_of_kernels_changes_their_digest(copied: Path, changed: str) -> None:
    assert digest_sources(copied) == digest_sources(PACKAGE)
    source = copied / changed
    source.write_text(source.read_text() + "\n")
    assert digest_sources(copied) != digest_sources(PACKAGE)


def test_a_source_without_kernels_does_not_count(copied: Path) -> None:
    source = copied / "rendering" / "picture.py"
    source.write_text(source.read_text() + "\n")
    assert digest_sources(copied) == digest_sources(PACKAGE)
