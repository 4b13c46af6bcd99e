"""A metric and a scenario from outside the package: tables, JSON, schema, lists, entries and workers have them."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hhrl_bench import Metric, Sum, evaluate, extensions, load_agent, register_metric
from hhrl_bench.evaluation import metric
from hhrl_bench.evaluation.evidence import pack, unpack
from hhrl_bench.evaluation.metrics import METRICS
from hhrl_bench.evaluation.paired_evaluation import play_task
from hhrl_bench.evaluation.store import Store, read
from hhrl_bench.execution.run import Execution
from hhrl_bench.extensions import VARIABLE, load_extensions
from hhrl_bench.leaderboard.entry import publish_entry, read_entry
from hhrl_bench.leaderboard.level import Level
from hhrl_bench.suites.study import suite_study
from hhrl_bench.suites.suites import ScoreSuite
from hhrl_bench.tasks.tasks import TASKS, get_task
from hhrl_bench.verification.checked_result import checked_results
from hhrl_bench.verification.verify import check_result, verify
from hhrl_envs import InputError
from hhrl_envs.scenario import registry
from support import small_board
from support.command_line import invoke

FOLDER = Path(__file__).parents[3] / "leaderboards"
EXTENSION = '''"""A metric and a scenario of a user."""

from dataclasses import replace

import hhrl_envs
from hhrl_bench import Least, Metric, Sum, register_metric
from hhrl_envs import Option, get_scenario

print("loaded")
register_metric(Metric("followed", "followed", Sum(lambda step: step.option == Option.FFV, whole=True), "steps in FFV"))
register_metric(Metric("least_reward", "least r", Least(lambda step: step.results.rewards), "smallest r^task"))
hhrl_envs.register(replace(get_scenario("stop-line-v0"), id="my-road-v0"))
'''
MINE = ("followed", "least_reward")
SUITE = ScoreSuite("small", agents=("rule-2", "rule-4"), tasks=("my-road-v0", "adversary-v0"), episodes=6)


@pytest.fixture(scope="module", autouse=True)
def extension(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The file of an extension, which is loaded for the tests of this module and gone after them."""
    path = tmp_path_factory.mktemp("extension") / "of_a_user.py"
    path.write_text(EXTENSION)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(VARIABLE, "")
        patch.setattr(extensions, "_hashes", {})  # what other tests hash is the package's own code again
        load_extensions([str(path)])
        yield path
    sys.modules.pop("of_a_user")
    registry._by_id.pop("my-road-v0")
    for key in MINE:
        metric._by_key.pop(key)


@pytest.fixture(scope="module")
def published(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An entry with the metrics of the extension, whose episodes were scored in worker processes."""
    folder = tmp_path_factory.mktemp("entry")
    study = suite_study(SUITE, folder)
    board = study.leaderboard(list(study.run(Execution(workers=2))))
    publish_entry(board, folder / "small.json", study.store)
    return folder / "small.json"


def command(*arguments: str, **environment: str) -> "subprocess.CompletedProcess[str]":
    """Run the command line in a process of its own, which has loaded nothing yet."""
    return subprocess.run(
        [sys.executable, "-m", "hhrl_bench", *arguments],
        env={**{name: value for name, value in os.environ.items() if name != VARIABLE}, **environment},
        capture_output=True,
        text=True,
        check=False,
    )


def test_an_extension_is_loaded_once_and_named_to_worker_processes(
    extension: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(extension.parent)
    load_extensions([extension.name, "hhrl_bench.errors"])
    assert os.environ[VARIABLE].split(os.pathsep) == [str(extension), "hhrl_bench.errors"]
    assert capsys.readouterr() == ("", "")
    assert sys.modules["of_a_user"].__file__ == str(extension)


def test_a_scenario_is_a_task() -> None:
    assert TASKS["my-road-v0"].scenario == "my-road-v0"
    assert "my-road-v0" in [task["id"] for task in json.loads(invoke("list", "tasks", "--json").stdout)]
    assert "my-road-v0" in invoke("list", "tasks").stdout


def test_a_metric_is_in_the_table_and_in_the_json(extension: Path) -> None:
    arguments = ("--extension", str(extension), "evaluate", "rule-4", "--task", "my-road-v0", "--episodes", "7")
    table = invoke(*arguments).stdout
    records = evaluate(load_agent("rule-4", "my-road-v0"), "my-road-v0", 7)
    assert "followed" in table
    assert f"{records.followed.mean():.2f}" in table
    assert records.followed.dtype == np.int32
    result = json.loads(invoke(*arguments, "--json").stdout)["results"][0]
    assert [*result["metrics"]] == [*result["runs"][0]["metrics"]] == [*METRICS]
    assert result["metrics"]["followed"]["mean"] == result["runs"][0]["metrics"]["followed"] == records.followed.mean()
    assert result["runs"][0]["metrics"]["least_reward"] == records.least_reward.mean()


def test_a_metric_follows_from_what_the_steps_hold() -> None:
    scored = play_task(load_agent("rule-4"), get_task("stop-line-v0"), get_task("stop-line-v0").test.take(5))
    ends = np.cumsum(scored.trace.steps)
    followed = [(part == 1).sum() for part in np.split(scored.trace.options[:, 0], ends[:-1])]
    np.testing.assert_array_equal(scored.records.followed, followed)
    np.testing.assert_array_equal(unpack(pack(scored)).measured["followed"], followed)


def test_the_schema_has_a_metric_that_entries_of_before_need_not_have() -> None:
    definitions = json.loads(invoke("leaderboard", "schema").stdout)["$defs"]
    for record in ("MetricsRecord", "RunMetricsRecord"):
        assert [*definitions[record]["properties"]] == [*METRICS]
        assert definitions[record]["required"] == [key for key, metric in METRICS.items() if metric.required]


def test_a_published_entry_without_the_metric_still_holds() -> None:
    board = read_entry(FOLDER / "quick.json")
    assert board.results[0].metrics.get("followed") is None
    assert "followed" not in board.results[0].metrics
    assert list(verify(board, Store(FOLDER), Level.SCHEMA)) == []
    assert check_result(Level.REPLAYED, checked_results(board, Store(FOLDER))[0], again=False) == ([], True)
    assert invoke("leaderboard", "show", str(FOLDER / "quick.json"), "--details").exit_code == 0


@pytest.mark.parametrize("level", [Level.RECOMPUTED, Level.RERUN])
def test_an_entry_with_the_metric_holds(published: Path, level: Level) -> None:
    board = read_entry(published)
    assert all(key in result.metrics for result in board.results for key in MINE)
    assert list(verify(board, Store(published.parent), level)) == []


@pytest.mark.parametrize(("key", "level"), [("followed", Level.RECOMPUTED), ("least_reward", Level.REPLAYED)])
def test_a_changed_number_of_the_metric_is_found(published: Path, key: str, level: Level) -> None:
    data = json.loads(published.read_text())
    data["results"][1]["runs"][0]["metrics"][key] += 1.0
    changed = published.with_name("changed.json")
    changed.write_text(json.dumps(data))
    places = [finding.place for finding in verify(read_entry(changed), Store(published.parent), level)]
    assert places == [f"results[1].runs[0].metrics.{key}"]


def test_evidence_that_lacks_the_numbers_of_the_metric_is_named(published: Path) -> None:
    data, store = json.loads(published.read_text()), Store(published.parent)
    run = data["results"][1]["runs"][0]
    kept = unpack(read(store.evidence(run["evidence_sha256"])))
    fewer = {key: numbers for key, numbers in kept.measured.items() if key != "followed"}
    run["evidence_sha256"] = store.add_evidence(small_board.repacked(kept._replace(measured=fewer)))
    changed = published.with_name("lacking.json")
    changed.write_text(json.dumps(data))
    said = [str(finding) for finding in verify(read_entry(changed), store, Level.RECOMPUTED)]
    assert "results[1].runs[0].metrics.followed: the evidence does not hold the numbers that it rests on" in said
    with pytest.raises(InputError, match="the episodes have no 'followed'"):
        METRICS["followed"].values(kept._replace(measured=fewer))


def test_an_entry_with_a_metric_that_is_not_registered_is_refused_in_one_line(published: Path, extension: Path) -> None:
    refused = command("leaderboard", "show", str(published))
    assert (refused.returncode, refused.stdout) == (2, "")
    assert len(refused.stderr.splitlines()) == 1
    assert "the metric 'followed' is not registered here; load the module that registers it: hhrl-bench --ext" in (
        refused.stderr
    )
    shown = command("leaderboard", "show", str(published), HHRL_EXTENSIONS=str(extension))
    assert (shown.returncode, shown.stderr) == (0, "loaded\n")
    assert "my-road-v0" in shown.stdout


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("nothing_there.py", "FileNotFoundError: there is no file"),
        ("nothing_there", "ModuleNotFoundError: No module named 'nothing_there'"),
        ("broken.py", "ZeroDivisionError: division by zero"),
        ("again.py", "there is a metric 'success' already; write another key"),
    ],
)
def test_what_cannot_be_loaded_is_one_line_and_exit_code_2(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("broken.py").write_text("1 / 0\n")
    Path("again.py").write_text(
        "from hhrl_bench import Metric, Sum, register_metric\n"
        "register_metric(Metric('success', 'mine', Sum(lambda step: step.running), 'another success'))\n"
    )
    result = invoke("--extension", name, "list", "tasks")
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith("hhrl-bench: cannot load the extension")
    assert said in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert "broken" not in sys.modules


@pytest.mark.parametrize("key", ["", "Two words", "seed", "outcome", "model_dump", "get", "copy", "1st"])
def test_words_that_are_no_keys_are_refused(key: str) -> None:
    with pytest.raises(InputError, match="cannot have the key"):
        register_metric(Metric(key, "heading", Sum(lambda step: step.running), "meaning"))
    assert key not in METRICS


def test_only_what_evidence_keeps_is_compared() -> None:
    real: Any = Metric("real", "real", Sum(lambda step: step.results.rewards), "a real number", compared=True)
    with pytest.raises(InputError, match="cannot be compared"):
        register_metric(real)


@pytest.mark.parametrize(
    ("declared", "said"),
    [
        ("Sum(lambda step: step.option[:3])", "return numbers of shape"),
        ("Sum(lambda step: None)", "returned object values of shape ()"),
        ("Sum(lambda step: 1 // 0)", "the function of metric 'bad' raised ZeroDivisionError"),
        ("Sum(lambda step: 0.5 * step.option, whole=True)", "return whole numbers, or leave out whole=True"),
        ("Least(lambda step: step.results.terms)", "return numbers of shape"),
        ("lambda ending: ending.steps[:2]", "return numbers of shape (5,)"),
        ("3", "write Sum, Least or a function of how episodes end"),
    ],
)
def test_a_metric_that_is_wrong_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, declared: str, said: str
) -> None:
    path = tmp_path / "bad_metric.py"
    path.write_text(
        f"from hhrl_bench import Least, Metric, Sum, register_metric\n"
        f"register_metric(Metric('bad', 'bad', {declared}, 'what is wrong'))\n"
    )
    monkeypatch.setenv(VARIABLE, "")
    monkeypatch.setattr(extensions, "_hashes", {})
    try:
        ran = invoke("--extension", str(path), "evaluate", "rule-2", "--episodes", "5")
    finally:
        sys.modules.pop("bad_metric", None)
        metric._by_key.pop("bad", None)
    assert (ran.exit_code, ran.stdout) == (2, "")
    assert said in ran.stderr.splitlines()[-1]
    assert "Traceback" not in ran.stderr


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[][0]\n", "IndexError: list index out of range (wrong.py, line 1)"),
        ("from hhrl_bench import register_metric\nregister_metric(3)\n", "cannot register 3 as a metric"),
        ("from hhrl_bench import register_suite\nregister_suite('x')\n", "cannot register 'x' as a suite"),
        ("from hhrl_agents import register_method\nregister_method('ddqn')\n", "cannot register 'ddqn' as a method"),
        ("from hhrl_agents import register_rule\nregister_rule('rule-new', 3)\n", "rule 'rule-new' is made by 3"),
        ("from hhrl_envs import register\nregister({})\n", "scenario is {}; write a Scenario"),
    ],
)
def test_an_extension_with_a_mistake_is_one_line_that_names_its_own(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "wrong.py").write_text(text)
    ran = command("--extension", str(tmp_path / "wrong.py"), "list", "tasks")
    assert (ran.returncode, ran.stdout, len(ran.stderr.splitlines())) == (2, "", 1)
    assert said in ran.stderr
    assert "(wrong.py, line" in ran.stderr
