"""A suite is a declaration: one that is registered from outside can be listed and run."""

import json
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

import pytest

import hhrl_bench
from hhrl_bench.errors import SuiteError
from hhrl_bench.suites import suites
from hhrl_bench.suites.suites import SUITES, ScoreSuite, Suite, get_suite
from support.command_line import invoke

MINE = ScoreSuite("mine", agents=("rule-2",), tasks=("stop-line-v0", "follow-v0"), episodes=3)


@pytest.fixture(autouse=True)
def registered(monkeypatch: pytest.MonkeyPatch) -> Mapping[str, Suite]:
    """Return the registered suites, of which none stays behind."""
    known = dict(SUITES)
    monkeypatch.setattr(suites, "_registered", known)
    monkeypatch.setattr(suites, "SUITES", MappingProxyType(known))
    return known


def test_a_registered_suite_is_listed_and_run(tmp_path: Path) -> None:
    hhrl_bench.register_suite(MINE)
    assert get_suite("mine") is MINE
    assert json.loads(invoke("list", "suites", "--json").stdout)[-1] == {
        "id": "mine", "tasks": [*MINE.tasks], "agents": ["rule-2"], "episodes": 3,
    }  # fmt: skip
    path = tmp_path / "mine.json"
    done = invoke("run", "--suite", "mine", "--work", str(tmp_path / "work"), "--out", str(path), "--workers", "1")
    assert done.exit_code == 0, done.stderr
    assert [result["task"] for result in json.loads(path.read_text())["results"]] == [*MINE.tasks]


def test_an_id_names_one_suite(registered: Mapping[str, Suite]) -> None:
    hhrl_bench.register_suite(MINE)
    hhrl_bench.register_suite(ScoreSuite("mine", MINE.agents, MINE.tasks, 3))
    with pytest.raises(SuiteError, match="there is a suite 'mine' already"):
        hhrl_bench.register_suite(ScoreSuite("mine", MINE.agents, MINE.tasks, 4))
    assert registered["mine"] is MINE
