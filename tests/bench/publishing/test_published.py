"""The published files are of this very version: the schema its records', the boards of its worlds and checkpoints."""

import hashlib
import json
from itertools import combinations
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from hhrl_agents import METHODS
from hhrl_agents.policies.checkpoint_file import SHIPPED
from hhrl_bench.evaluation.evidence import read_evidence
from hhrl_bench.evaluation.store import Store
from hhrl_bench.leaderboard.entry import read_entry
from hhrl_bench.leaderboard.entry_files import entry_paths
from hhrl_bench.leaderboard.level import Level
from hhrl_bench.publishing.copies import MOST_ALIKE, Stored, runs_on, shared
from hhrl_bench.publishing.publication import check_index
from hhrl_bench.suites.suites import SUITES
from hhrl_bench.suites.units import SeedTraining
from hhrl_bench.verification.checked_result import checked_results
from hhrl_bench.verification.identity import check_weights
from hhrl_bench.verification.verify import check_result, verify
from hhrl_envs import Outcome, get_scenario
from support.command_line import invoke

ROOT = Path(__file__).parents[3]
FOLDER = ROOT / "leaderboards"
FOR_NO_BOARD = {"follow-only", "adversary", "platoon"}  # a part of option-only, an opponent, a driver of all vehicles
SCHEMA = FOLDER / "schema.json"
EACH_BOARD = pytest.mark.parametrize("path", entry_paths(FOLDER), ids=lambda path: path.stem)


def test_the_published_schema_is_that_of_the_records() -> None:
    assert invoke("leaderboard", "schema").stdout == SCHEMA.read_text()


def checkpoints(method: str) -> set[str]:
    """The SHA-256 of every trained seed that comes with the package."""
    return {hashlib.sha256(file.read_bytes()).hexdigest() for file in SHIPPED.glob(f"{method}/*.safetensors")}


@EACH_BOARD
def test_a_published_leaderboard_keeps_to_the_published_schema(path: Path) -> None:
    validator = jsonschema.Draft202012Validator(json.loads(SCHEMA.read_text()))
    board = json.loads(path.read_text())
    validator.validate(board)
    board["results"][0]["runs"][0]["episodes_sha256"] = "short"
    assert [error.json_path for error in validator.iter_errors(board)] == ["$.results[0].runs[0].episodes_sha256"]


@EACH_BOARD
def test_a_published_leaderboard_is_verified_and_some_of_its_agents_run_again(path: Path) -> None:
    """All means follow from its evidence; two of its results are replayed, and their agents run again."""
    board, store = read_entry(path), Store(FOLDER)
    assert list(map(str, verify(board, store, Level.SCHEMA))) == []
    assert list(map(str, check_weights(board, store))) == []
    results = checked_results(board, store)
    assert [str(finding) for result in results for finding in result.recompute(replayed=True)] == []
    for index in np.random.default_rng(len(path.stem)).permutation(len(results))[:2]:
        results[index].forget()
        assert check_result(Level.RERUN, results[index], again=True) == ([], True)


def test_comparisons_and_curves_of_a_published_leaderboard_are_computed_again() -> None:
    board, store = read_entry(FOLDER / "trainings.json"), Store(FOLDER)
    assert list(map(str, verify(board, store, Level.RECOMPUTED))) == []


@EACH_BOARD
def test_nobody_is_quicker_than_the_oracle(path: Path) -> None:
    """But for what steps, levels and the actuator's lag cost its plans: four steps at most."""
    store, episodes = Store(FOLDER), 0
    for result in read_entry(path).results:
        for run in result.runs:
            evidence = read_evidence(run, store)
            if "fewest_steps" in evidence.measured:
                stopped = evidence.outcome == int(Outcome.SUCCESS)
                fewest, steps = evidence.measured["fewest_steps"][stopped], evidence.steps[stopped]
                assert (steps >= fewest - 4).all(), result.agent
                episodes += stopped.sum()
    assert episodes > 1000


@pytest.mark.parametrize("name", [path.stem for path in entry_paths(FOLDER) if path.stem in SUITES])
def test_a_leaderboard_named_after_a_suite_holds_all_of_it(name: str) -> None:
    board, suite = read_entry(FOLDER / f"{name}.json"), SUITES[name]
    assert board.suite == name
    assert {task.id: task.episodes for task in board.tasks} == dict.fromkeys(suite.tasks, suite.episodes)
    units = {unit.name for stage in suite.stages(Path()) for unit in stage if not isinstance(unit, SeedTraining)}
    results = {f"{result.agent} on {result.task}": result for result in board.results}
    assert set(results) == units
    for training in suite.curves(Path()).trainings:
        result = results[training.name]
        assert sorted((*result.seeds, *result.failed_seeds)) == list(training.seeds)


def test_the_index_is_of_the_published_files() -> None:
    assert list(map(str, check_index(FOLDER))) == []


def test_what_is_published_is_fit_for_a_repository() -> None:
    assert sum(path.stat().st_size for path in FOLDER.rglob("*") if path.is_file()) < 40 * 10**6


@EACH_BOARD
def test_a_published_leaderboard_is_of_this_version(path: Path) -> None:
    board = read_entry(path)
    for task in board.tasks:
        assert task.spec_hash == get_scenario(task.scenario).spec_hash
        if task.opponent:
            assert task.opponent.checkpoint_sha256 in checkpoints(task.opponent.agent)


@pytest.mark.parametrize("name", ["quick", "robustness"])
def test_a_leaderboard_of_shipped_agents_scores_the_shipped_checkpoints(name: str) -> None:
    board = read_entry(FOLDER / f"{name}.json")
    shipped = {sha256 for method in METHODS if method not in FOR_NO_BOARD for sha256 in checkpoints(method)}
    learned = {run.checkpoint_sha256 for result in board.results if result.kind == "learned" for run in result.runs}
    assert learned == shipped


def test_published_agents_that_differ_share_few_episodes() -> None:
    """The share in docs/leaderboards.md, of runs under different names that do not drive alike in every episode."""
    entries = {path.name: Stored(read_entry(path), Store(FOLDER)) for path in entry_paths(FOLDER)}
    found = []
    for task in sorted({task.id for entry in entries.values() for task in entry.board.tasks}):
        runs = [run for name, entry in entries.items() for run in runs_on(name, entry, task)]
        pairs = [(one, other) for one, other in combinations(runs, 2) if one.agent != other.agent]
        found += [(shared(*pair), task, {one.agent for one in pair}) for pair in pairs]
    share, task, agents = max(one for one in found if one[0] < 1.0)
    page = " ".join((ROOT / "docs" / "leaderboards.md").read_text().split())
    assert agents == {"rule-3", "rule-4"}
    assert f"published agents, `rule-3` and `rule-4` in `{task}`, share {share:.0%}." in page
    assert share < MOST_ALIKE
