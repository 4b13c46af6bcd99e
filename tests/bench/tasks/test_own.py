"""Tasks of users' own: a file or a module in place of an id, and none that passes for a registered one."""

import pickle
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from hhrl_bench.errors import TaskError, UnknownTaskError
from hhrl_bench.extensions import VARIABLE, load_extensions
from hhrl_bench.suites.suites import SUITES
from hhrl_bench.tasks.tasks import TASKS, Task, get_task, registered_task
from hhrl_envs import SCENARIOS, InputError, get_scenario, scenario_to_json
from support.own_scenarios import forgotten_scenarios

MAIN = SCENARIOS["stop-line-v0"]
OWN = replace(MAIN, id="my-road-v0", road=replace(MAIN.road, friction=0.5))

MODULE = """
from dataclasses import replace
from hhrl_envs import SCENARIOS
own = replace(SCENARIOS["stop-line-v0"], id="mine-v0", horizon=700)
platoon = replace(SCENARIOS["platoon-v0"], id="my-platoon-v0")
def make():
    return replace(own, id="made-v0")
def failing():
    raise RuntimeError("out of paint")
def wrong():
    return replace(own, horizon=-1)
number = 3
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The current folder, with a scenario file and a module in it; what is registered is forgotten again."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text(MODULE)
    (tmp_path / "road.json").write_text(scenario_to_json(OWN))
    with forgotten_scenarios():
        yield tmp_path


@pytest.mark.parametrize(
    ("source", "task_id"), [("road.json", "my-road-v0"), ("mine:own", "mine-v0"), ("mine:make", "made-v0")]
)
def test_a_file_or_a_module_is_a_task_with_the_usual_budget_and_seeds(source: str, task_id: str) -> None:
    task = get_task(source)
    assert task == Task(task_id, task_id, env_steps=1_000_000) == get_task(source)
    assert (task.train, task.test) == (get_task("stop-line-v0").train, get_task("stop-line-v0").test)
    assert get_task(get_scenario(task_id)) == get_task(task_id) == task
    assert get_task("mine:platoon").shared


def test_a_path_and_a_scenario_are_taken_too(folder: Path) -> None:
    assert get_task(folder / "road.json") == get_task(OWN)


def test_another_process_knows_the_scenario_of_a_task() -> None:
    with forgotten_scenarios():
        sent = pickle.dumps(get_task("road.json"))
    assert "my-road-v0" not in SCENARIOS
    assert pickle.loads(sent) == TASKS["my-road-v0"]  # noqa: S301
    assert get_scenario("my-road-v0") == OWN


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("nowhere.json", "cannot read nowhere.json: No such file or directory"),
        ("mine.py", "'mine.py' is a file of Python; write module:scenario, such as mine:SCENARIO"),
        (
            "nowhere:own",
            "cannot take the scenario nowhere:own: ModuleNotFoundError: No module named 'nowhere'",
        ),
        ("mine:other", "mine:other is no scenario: there is no such name; name a Scenario"),
        ("mine:number", "mine:number is no scenario: it is int; name a Scenario"),
        ("mine:failing", "cannot take the scenario mine:failing: RuntimeError: out of paint"),
        ("mine:wrong", "mine:wrong: Scenario.horizon is -1; write an integer from 1"),
        (":own", "cannot take the scenario :own: ValueError"),
        ("x" * 5000, "unknown task 'xxx"),
    ],
)
def test_what_is_no_task_is_said_in_one_line(source: str, said: str) -> None:
    with pytest.raises(InputError) as caught:
        get_task(source)
    assert str(caught.value).startswith(said)
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize("task_id", ["stop-line-v0", "Stop-Line-v0", "stop_line-vO", "option-only-v0"])
def test_no_task_passes_for_a_registered_one(folder: Path, task_id: str) -> None:
    (folder / "road.json").write_text(scenario_to_json(replace(OWN, id=task_id)))
    with pytest.raises(TaskError, match=f"the id '{task_id}' is .* write another id, such as 'my-road-v0'"):
        get_task("road.json")
    assert SCENARIOS["stop-line-v0"] == MAIN


def test_an_equal_scenario_is_the_registered_one(folder: Path) -> None:
    (folder / "road.json").write_text(scenario_to_json(MAIN))
    assert get_task("road.json") is not None
    assert get_scenario(get_task("road.json").scenario).spec_hash == MAIN.spec_hash


def test_a_registered_id_is_no_file_and_suites_stay_what_they_are(folder: Path) -> None:
    (folder / "stop-line-v0").write_text(scenario_to_json(OWN))
    before = dict(SUITES)
    assert get_task("stop-line-v0").scenario == "stop-line-v0"
    assert "my-road-v0" not in SCENARIOS
    get_task("road.json")
    assert dict(SUITES) == before


@pytest.mark.parametrize("name", ["road.json", "mine:own", "/etc/hosts"])
def test_what_others_have_written_reads_no_file_and_no_module(name: str) -> None:
    with pytest.raises(UnknownTaskError, match="unknown task"):
        registered_task(name)
    assert "mine" not in sys.modules


def test_a_scenario_file_is_an_extension(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "")
    monkeypatch.setattr("hhrl_bench.extensions._hashes", {})
    load_extensions(["road.json"])
    assert get_task("my-road-v0").scenario == "my-road-v0"
    (folder / "bad.json").write_text("{}")
    with pytest.raises(InputError, match=r"cannot load the extension '.*': .*bad\.json: it lacks 'id'; add it"):
        load_extensions(["bad.json"])
