"""Suites of users' own as files: checked, run like others, and none that passes for a registered one."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from hhrl_bench.leaderboard.entry import read_entry
from hhrl_bench.suites.files import find_suite
from hhrl_bench.suites.suites import SUITES, ScoreSuite
from hhrl_envs import SCENARIOS, InputError, scenario_to_json
from support.command_line import invoke
from support.own_scenarios import forgotten_scenarios

HONEST = {"id": "my-suite", "tasks": ["road.json", "solo-stop-v0"], "agents": ["rule-3", "rule-4"], "episodes": 3}


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The current folder, with a scenario file in it."""
    monkeypatch.chdir(tmp_path)
    text = scenario_to_json(SCENARIOS["solo-stop-v0"]).replace("solo-stop-v0", "my-road-v0")
    (tmp_path / "road.json").write_text(text.replace('"horizon": 600', '"horizon": 500'))
    with forgotten_scenarios():
        yield tmp_path


def write(**changes: Any) -> str:
    data = {key: value for key, value in (HONEST | changes).items() if value is not None}
    Path("suite.json").write_text(json.dumps(data))
    return "suite.json"


def test_a_file_is_a_suite_that_runs() -> None:
    assert find_suite(write()) == ScoreSuite("my-suite", ("rule-3", "rule-4"), ("my-road-v0", "solo-stop-v0"), 3)
    assert "my-suite" not in SUITES
    result = invoke("run", "--suite", "suite.json", "--workers", "1")
    assert result.exit_code == 0, result.output
    board = read_entry(Path("runs/my-suite/entry.json"))
    assert board.suite == "my-suite"
    assert board.provenance.command == "hhrl-bench run --suite suite.json"
    assert [(one.agent, one.task) for one in board.results][::3] == [
        ("rule-3", "my-road-v0"),
        ("rule-4", "solo-stop-v0"),
    ]


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"id": "quick"}, "the id 'quick' is or looks like that of the suite quick; write another id"),
        ({"id": "qu1ck"}, "the id 'qu1ck' is or looks like that of the suite quick"),
        ({"id": "../escape"}, "id: write a string that matches"),
        ({"id": "index"}, "id: write another name than index"),
        ({"id": None}, "id: is missing; add it"),
        ({"tasks": []}, "tasks: write a list with at least 1"),
        ({"tasks": ["stop-lin"]}, "unknown task 'stop-lin', did you mean stop-line-v0"),
        ({"tasks": ["os:abort"]}, "'os:abort' may be code, which a suite file cannot run; name ids and scenario files"),
        ({"tasks": ["road.json", "my-road-v0"]}, "the task 'my-road-v0' is named twice; name each once"),
        ({"agents": ["rule-4", "rule-4"]}, "the agent 'rule-4' is named twice; name each once"),
        ({"agents": "rule-4"}, "agents: write "),
        ({"episodes": "5"}, "episodes: write "),
        ({"episodes": 0}, "episodes: write a number greater"),
        ({"seeds": 3}, "seeds: is not known; leave it out"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(changes: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError) as caught:
        find_suite(write(**changes))
    assert said in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


def test_a_file_that_is_none_and_an_id_that_is_nearly_one() -> None:
    for name, said in (
        ("nowhere.json", "cannot read nowhere.json: No such file or directory; name a suite file, such as {"),
        ("quikc", "unknown suite 'quikc', did you mean quick; known suites: quick, "),
    ):
        result = invoke("run", "--suite", name)
        assert (result.exit_code, result.stdout) == (2, "")
        assert result.stderr.startswith(f"hhrl-bench: {said}")
