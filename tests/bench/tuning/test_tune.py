import json
from pathlib import Path

import pytest

from hhrl_agents.rules.tuned_rule import ALL_TASKS, HELD_OUT, ROBUST, TUNED, stored
from hhrl_agents.rules.tuning import FIRST_TUNING, bounds
from hhrl_bench import evaluate
from hhrl_bench.evaluation.records import MetricRecord
from hhrl_bench.tasks.tasks import TASKS, get_task
from hhrl_bench.tuning import search as searching
from hhrl_bench.tuning.search import search
from hhrl_bench.tuning.tune import TuningRecord, tunable_tasks
from hhrl_envs import InputError, get_scenario
from hhrl_envs.scenario.registry import SUPERSEDED
from support.command_line import invoke

SMALL = "solo-stop-v0"
ENOUGH, TOO_FEW = 60_000, 5_000


def shipped(rule: str) -> TuningRecord:
    return TuningRecord.model_validate_json(stored(rule).read_bytes())


def mean(metric: MetricRecord) -> float:
    assert metric.mean is not None
    return metric.mean


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let every candidate drive in few worlds."""
    for name, number in {"POPULATION": 6, "SEARCH_WORLDS": 3, "FRESH_EPISODES": 28}.items():
        monkeypatch.setattr(searching, name, number)


def test_what_is_shipped_is_found_again() -> None:
    found, task = shipped(TUNED).sets[SMALL], get_task(SMALL)
    again = search([task], task.env_steps, found.seed, lambda *_: None)
    assert (again.tuning, again.score, again.worlds) == (found.tuning, found.score, found.episodes)
    assert (again.candidates, again.env_steps) == (found.candidates, found.env_steps)


@pytest.mark.parametrize("rule", [TUNED, ROBUST])
def test_what_is_shipped_was_found_in_the_worlds_of_today(rule: str) -> None:
    for name, found in shipped(rule).sets.items():
        for scenario, spec_hash in found.scenarios.items():
            assert spec_hash == get_scenario(scenario).spec_hash, f"run: hhrl-bench tune {rule} --task {scenario}"
        assert name == ALL_TASKS or list(found.scenarios) == [name]


def test_every_task_with_scripted_traffic_has_its_set_but_for_held_out_drivers() -> None:
    scripted = {one.scenario for one in TASKS.values() if not get_scenario(one.scenario).learned_fronts}
    searched = scripted - set(HELD_OUT) - set(SUPERSEDED)
    assert {one.scenario for one in tunable_tasks()} == searched
    assert set(shipped(TUNED).sets) == searched
    assert set(shipped(ROBUST).sets[ALL_TASKS].scenarios) == searched


@pytest.mark.parametrize("rule", [TUNED, ROBUST])
def test_a_search_spends_the_training_budget_of_its_tasks(rule: str) -> None:
    budgets = {task.scenario: task.env_steps for task in tunable_tasks()}
    for found in shipped(rule).sets.values():
        budget = sum(budgets[name] for name in found.scenarios)
        assert 0.999 * budget < found.env_steps <= budget


@pytest.mark.parametrize("task", ["stop-line-v0", "stop-line-paper-v0"])
def test_the_tuned_rule_scores_higher_than_rule_plus(task: str) -> None:
    scored = evaluate([TUNED, "rule-plus"], task, episodes=100)
    tuned, plus = (scored[rule].result.metrics for rule in (TUNED, "rule-plus"))
    assert mean(tuned.score) > mean(plus.score) + 0.05
    assert mean(tuned.success) >= 0.98


@pytest.mark.usefixtures("quick")
def test_a_search_repeats_itself_and_is_no_worse_than_its_first_guess() -> None:
    tasks, heard = [get_task(SMALL)], []
    first = search(tasks, ENOUGH, 3, lambda *said: heard.append(said))
    assert search(tasks, ENOUGH, 3, lambda *_: None) == first
    assert search(tasks, ENOUGH, 4, lambda *_: None).tuning != first.tuning
    assert first.tuning != {name: getattr(FIRST_TUNING, name) for name in bounds()}
    assert ENOUGH - 6 * 12 < first.env_steps <= ENOUGH
    assert [done for done, _, _ in heard] == sorted(done for done, _, _ in heard)


@pytest.mark.usefixtures("quick")
def test_too_few_steps_are_said_in_one_line() -> None:
    with pytest.raises(InputError, match="1000 steps are too few for a search; write more --env-steps"):
        search([get_task(SMALL)], 1_000, 0, lambda *_: None)


@pytest.mark.usefixtures("quick")
def test_the_file_keeps_the_sets_that_are_not_searched_for_anew(tmp_path: Path) -> None:
    path, words = tmp_path / "new" / "sets.json", ("--env-steps", str(ENOUGH), "--json")
    first = invoke("tune", TUNED, "--task", SMALL, "--out", str(path), *words)
    assert first.exit_code == 0, first.stderr
    second = invoke("tune", TUNED, "--task", "stop-line-paper-v0", "--out", str(path), *words)
    assert list(json.loads(second.stdout)["sets"]) == [SMALL, "stop-line-paper-v0"]
    assert json.loads(path.read_text()) == json.loads(second.stdout)
    assert json.loads(first.stdout)["sets"][SMALL] == json.loads(second.stdout)["sets"][SMALL]


@pytest.mark.usefixtures("quick")
def test_a_search_for_all_tasks_makes_one_set_and_prints_its_numbers_with_units() -> None:
    said = invoke("tune", ROBUST, "--task", SMALL, "--task", "stop-line-paper-v0", "--env-steps", str(2 * ENOUGH))
    assert said.exit_code == 0, said.stderr
    assert ALL_TASKS in said.stdout.splitlines()[1]
    assert any(line.startswith("headway, s ") for line in said.stdout.splitlines())


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (("rule-4",), "'rule-4' has no numbers to search for; write one of: rule-tuned, rule-robust"),
        ((TUNED, "--task", "platoon-v0"), "platoon-v0 has learned front vehicles, and so no score to search by"),
        ((TUNED, "--task", SMALL, "--task", SMALL), f"task '{SMALL}' is named twice"),
        ((TUNED, "--out", "other.json"), "other.json is no file of tunings"),
        ((TUNED, "--out", "short.json"), "short.json is no file of tunings"),
        ((TUNED, "--out", "robust.json"), "robust.json holds the numbers of rule-robust; write another --out"),
        ((TUNED, "--out", "robust.json/deeper"), "cannot write robust.json/deeper"),
    ],
)
def test_what_cannot_be_searched_for_is_said_before_any_search(
    words: tuple[str, ...], problem: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(searching, "differential_evolution", None)
    Path("other.json").write_text('{"schema_version": 1}\n')
    Path("robust.json").write_bytes(stored(ROBUST).read_bytes())
    lacking = json.loads(stored(TUNED).read_text())
    del next(iter(lacking["sets"].values()))["tuning"]["hidden"]
    Path("short.json").write_text(json.dumps(lacking))
    said = invoke("tune", *words)
    assert said.exit_code == 2
    assert problem in said.stderr
    assert len(said.stderr.splitlines()) == 1
    assert Path("robust.json").read_bytes() == stored(ROBUST).read_bytes()
