"""Films of failures: the very episodes that failed, from stored decisions, also of agents that are not there."""

from pathlib import Path

import pytest

from hhrl_bench.errors import RecordError
from hhrl_bench.evaluation.store import Store
from hhrl_bench.figures.watch import failures, film_failures
from hhrl_bench.leaderboard.entry import publish_entry, read_entry
from hhrl_bench.suites.study import suite_study
from hhrl_bench.suites.suites import ScoreSuite
from hhrl_envs import Outcome
from support.command_line import invoke

SUITE = ScoreSuite("small", agents=("rule-2", "rule-plus"), tasks=("stop-line-v0", "adversary-v0"), episodes=12)


@pytest.fixture(scope="module")
def entry(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("entry")
    study = suite_study(SUITE, folder)
    board = study.leaderboard(list(study.run()))
    publish_entry(board, folder / "small.json", study.store)
    return folder / "small.json"


@pytest.mark.parametrize("task", SUITE.tasks)
def test_films_are_of_the_episodes_that_failed_and_end_as_those_did(entry: Path, task: str, tmp_path: Path) -> None:
    board, store = read_entry(entry), Store(entry.parent)
    failed = list(failures(board, store, "rule-2", task))
    (run,) = next(result for result in board.results if (result.agent, result.task) == ("rule-2", task)).runs
    assert len(failed) == round(12 * (1 - run.metrics.success))
    films = list(film_failures(board, store, "rule-2", task, 2, tmp_path / "film.png"))
    assert [path.name for path, _ in films] == [f"film-episode-{failure.episode}.png" for failure in failed[:2]]
    assert all(path.exists() and outcome != Outcome.SUCCESS for path, outcome in films)


def test_what_an_entry_does_not_have_is_one_line(entry: Path, tmp_path: Path) -> None:
    board, store = read_entry(entry), Store(entry.parent)
    assert not list(failures(board, store, "rule-plus", "stop-line-v0"))
    with pytest.raises(RecordError, match="the entry has no ddqn on stop-line-v0; it has rule-2 on stop-line-v0"):
        list(film_failures(board, store, "ddqn", "stop-line-v0", 1, tmp_path / "film.gif"))
    said = invoke("watch", "rule-plus", "--failed", "1", "--entry", str(entry), "--out", str(tmp_path / "film.gif"))
    assert (said.exit_code, said.stdout) == (0, "")
    assert "has no failure of rule-plus on stop-line-v0" in said.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("option", ["--episode", "--option", "--opponent"])
def test_options_that_a_film_of_failures_cannot_heed_are_refused(entry: Path, tmp_path: Path, option: str) -> None:
    given = {"--episode": "0", "--option": "stop", "--opponent": "rule-2"}[option]
    wanted = ("--failed", "1", "--entry", str(entry), "--out", str(tmp_path / "film.gif"))
    said = invoke("watch", "rule-2", option, given, *wanted)
    assert said.exit_code == 2
    assert said.stderr.startswith(f"hhrl-bench: Invalid value for {option}: it says nothing to --failed")
