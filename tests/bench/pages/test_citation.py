"""CITATION.cff: what the Citation File Format 1.2.0 requires, this version of the software, and the paper."""

import tomllib
from pathlib import Path
from typing import Any

import yaml

ROOT = Path(__file__).parents[3]
PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
CITATION: dict[str, Any] = yaml.safe_load((ROOT / "CITATION.cff").read_text())
(PAPER,) = CITATION["references"]


def test_the_keys_that_the_format_requires_are_there() -> None:
    assert CITATION["cff-version"] == "1.2.0"
    assert {"message", "title", "authors"} <= CITATION.keys()
    assert {"type", "title", "authors"} <= PAPER.keys()
    for author in [*CITATION["authors"], *PAPER["authors"]]:
        assert author.keys() in ({"name"}, {"given-names", "family-names"})


def test_it_speaks_of_this_version_of_the_software() -> None:
    assert CITATION["type"] == "software"
    assert CITATION["title"].startswith(PROJECT["name"])
    assert CITATION["version"] == PROJECT["version"]
    assert CITATION["license"] == PROJECT["license"]
    assert [author["name"] for author in CITATION["authors"]] == [author["name"] for author in PROJECT["authors"]]


def test_it_names_the_paper() -> None:
    assert PAPER["title"] == "Hierarchical Reinforcement Learning Method for Autonomous Vehicle Behavior Planning"
    names = [author["family-names"] for author in PAPER["authors"]]
    assert names == ["Qiao", "Tyree", "Mudalige", "Schneider", "Dolan"]
    assert PAPER["year"] == 2020
    assert PAPER["url"].endswith("1911.03799")
