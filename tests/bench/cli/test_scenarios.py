"""The commands for scenario files, and the commands that take one as a task."""

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from hhrl_envs import SCENARIOS, scenario_from_json
from support.command_line import invoke
from support.own_scenarios import forgotten_scenarios


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The current folder; what is registered is forgotten again."""
    monkeypatch.chdir(tmp_path)
    with forgotten_scenarios():
        yield tmp_path


def test_a_scenario_is_shown_as_a_file_and_checked(folder: Path) -> None:
    shown = invoke("scenario", "show", "stop-line-v0")
    assert shown.exit_code == 0
    assert scenario_from_json(shown.stdout) == SCENARIOS["stop-line-v0"]
    (folder / "road.json").write_text(shown.stdout.replace("stop-line-v0", "my-road-v0"))
    checked = invoke("scenario", "check", "road.json")
    assert checked.exit_code == 0
    assert "my-road-v0: a valid scenario" in checked.stdout
    assert "goal STOP, options stop, follow, 6 levels, 600 steps" in checked.stdout
    assert "100.0% of 1,000 worlds as they are drawn can be solved; others are drawn anew" in checked.stdout
    assert "training budget 1,000,000 env steps a seed; worlds: train from 0, validation from 1,000,000,000, test" in (
        checked.stdout
    )


def test_few_worlds_that_can_be_solved_are_told(folder: Path) -> None:
    data = json.loads(invoke("scenario", "show", "stop-line-v0").stdout)
    road = data["road"] | {"start_distance": [2, 3], "friction": 0.05}
    (folder / "near.json").write_text(json.dumps(data | {"id": "near-v0", "road": road, "feasible_only": False}))
    checked = invoke("scenario", "check", "near.json")
    assert checked.exit_code == 0
    assert "0.0% of 1,000 worlds as they are drawn can be solved; others are kept\nfew: give it wider" in checked.stdout


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("scenario", "check", "nowhere.json"), "cannot read nowhere.json: No such file or directory"),
        (
            ("scenario", "check", "bad.json"),
            "bad.json: it has the unknown key 'idd', did you mean 'id'; write some of",
        ),
        (("scenario", "check", "wet.json"), "wet.json: road.friction is 7; write a coefficient from 0.01 to 1.5"),
        (
            ("scenario", "check", "short.json"),
            "scenario 'my-road-v0' draws no feasible world; give it wider gaps, more",
        ),
        (("scenario", "show", "stop-lin"), "unknown task 'stop-lin', did you mean stop-line-v0; known tasks: "),
        (("evaluate", "rule-4", "--task", "taken.json"), "the id 'stop-line-v0' is that of a registered scenario with"),
        (("transfer", "--source", "ddqn", "--target", "bad.json"), "bad.json: it has the unknown key 'idd'"),
    ],
)
def test_bad_input_is_one_line(words: tuple[str, ...], said: str, folder: Path) -> None:
    data = json.loads(invoke("scenario", "show", "stop-line-v0").stdout)
    (folder / "bad.json").write_text(json.dumps({"idd": "my-road-v0"}))
    (folder / "taken.json").write_text(json.dumps(data | {"horizon": 700}))
    for name, road in (("wet", {"friction": 7}), ("short", {"start_distance": [2, 3], "friction": 0.05})):
        own = {"id": "my-road-v0", "road": data["road"] | road}
        (folder / f"{name}.json").write_text(json.dumps(data | own))
    result = invoke(*words)
    assert (result.exit_code, result.stdout) == (2, "")
    (line,) = result.stderr.splitlines()
    assert line.startswith(f"hhrl-bench: {said}")


def test_policies_are_reused_in_a_task_of_ones_own(folder: Path) -> None:
    data = json.loads(invoke("scenario", "show", "solo-stop-v0").stdout)
    (folder / "road.json").write_text(json.dumps(data | {"id": "my-road-v0"}))
    words = ("--source", "ddqn", "--target", "road.json", "--seeds", "0", "--env-steps", "300", "--episodes", "2")
    result = invoke("transfer", *words, "--out", "transfer", "--workers", "1")
    assert result.exit_code == 0, result.output
    board = json.loads((folder / "transfer" / "transfer.json").read_text())
    assert [task["id"] for task in board["tasks"]] == ["my-road-v0"]
