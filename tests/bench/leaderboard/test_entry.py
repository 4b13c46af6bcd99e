"""Leaderboards: strict records, equal runs equal digit for digit, files read whole or refused in one line."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from hhrl_agents import METHODS, ORACLES, RULES
from hhrl_bench.errors import AgentError, RecordError, UnknownSuiteError
from hhrl_bench.evaluation.metrics import METRICS
from hhrl_bench.evaluation.sources import shipped_methods
from hhrl_bench.leaderboard.entry import read_entry, write_entry
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.suites import units
from hhrl_bench.suites.study import suite_study
from hhrl_bench.suites.suites import SUITES, ScoreSuite, Suite, get_suite
from hhrl_bench.tasks.tasks import TASKS, TEST

TINY = ScoreSuite("tiny", agents=("rule-1", "rule-2"), tasks=("stop-line-v0",), episodes=30)
Json = dict[str, Any]


def make(folder: Path) -> LeaderboardRecord:
    study = suite_study(TINY, folder)
    return study.leaderboard(list(study.run()))


@pytest.fixture(scope="module")
def board(tmp_path_factory: pytest.TempPathFactory) -> LeaderboardRecord:
    return make(tmp_path_factory.mktemp("board"))


def test_two_runs_differ_in_their_provenance_at_most(board: LeaderboardRecord, tmp_path: Path) -> None:
    again = make(tmp_path)
    assert board.model_dump_json(exclude={"provenance"}) == again.model_dump_json(exclude={"provenance"})


def test_a_written_leaderboard_reads_back_equal(board: LeaderboardRecord, tmp_path: Path) -> None:
    write_entry(board, tmp_path / "a.json")
    assert read_entry(tmp_path / "a.json") == board
    write_entry(read_entry(tmp_path / "a.json"), tmp_path / "b.json")
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()


def test_a_leaderboard_says_what_was_played(board: LeaderboardRecord) -> None:
    (task,) = board.tasks
    assert (task.id, task.test_start, task.episodes) == ("stop-line-v0", TEST.start, 30)
    assert [result.agent for result in board.results] == ["rule-1", "rule-2"]
    assert set(board.provenance.wall_seconds) == {"stop-line-v0/rule-1", "stop-line-v0/rule-2"}
    for result in board.results:
        assert (result.kind, result.option, len(result.runs), result.seeds) == ("rule", None, 1, ())
        assert result.metrics.success.interval == "wilson-episodes"
        assert result.metrics.steps.interval == "bootstrap-episodes"
        assert result.metrics.declarations() == [*METRICS.values()]
        for key in METRICS:
            metric = getattr(result.metrics, key)
            assert metric.mean == getattr(result.runs[0].metrics, key)
            assert metric.mean is None or metric.interval == "none" or metric.low <= metric.mean <= metric.high
        assert result.metrics.success.n == result.metrics.return_task.n == 30
    assert board.results[0].runs[0].episodes_sha256 != board.results[1].runs[0].episodes_sha256


def test_records_do_not_change(board: LeaderboardRecord) -> None:
    with pytest.raises(ValidationError, match="frozen"):
        board.suite = "other"


def change(path: str, value: object) -> Callable[[Json], None]:
    *folders, last = path.split(".")

    def apply(data: Any) -> None:
        for name in folders:
            data = data[int(name) if name.isdigit() else name]
        if value is ...:
            del data[last]
        else:
            data[last] = value

    return apply


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (change("extra", 1), "extra: is not known; leave it out"),
        (change("schema_version", ...), "schema_version: is missing; add it"),
        (change("schema_version", 2), "schema_version: write 1"),
        (change("suite", ""), "suite: write a string that matches pattern"),
        (change("tasks", []), "tasks: "),
        (change("tasks.0.spec_hash", "00"), "tasks.0.spec_hash: "),
        (change("results.0.runs.0.metrics.collision", 1.5), "less than or equal to 1"),
        (change("results.0.runs.0.metrics.success", "1"), "results.0.runs.0.metrics.success: "),
        (change("results.0.runs", []), "results.0.runs: "),
        (change("results.1.metrics.steps.mean", float("nan")), "results.1.metrics.steps.mean: .*finite"),
        (change("results.1.metrics.steps.low", float("-inf")), "results.1.metrics.steps.low: .*finite"),
        (change("results.1.metrics.steps.n", 30.5), "results.1.metrics.steps.n: "),
        (change("results.1.metrics.steps.interval", "normal"), "results.1.metrics.steps.interval: "),
        (change("results.1.agent", "rule-1"), "rule-1 has two results on stop-line-v0"),
        (change("results.1.task", "other-v0"), "rule-2 has a result on other-v0"),
        (change("provenance.git_commit", "abc"), "provenance.git_commit: "),
    ],
)
def test_a_spoilt_leaderboard_is_refused_in_one_line(
    board: LeaderboardRecord, tmp_path: Path, spoil: Callable[[Json], None], said: str
) -> None:
    data = json.loads(board.model_dump_json())
    spoil(data)
    path = tmp_path / "spoilt.json"
    path.write_text(json.dumps(data))
    with pytest.raises(RecordError, match=said) as caught:
        read_entry(path)
    assert "spoilt.json is no leaderboard" in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize("text", [b"", b"{}", b"[]", b"null", b"\xff\xfe", b'{"suite":', b"[" * 100_000])
def test_what_is_no_leaderboard_is_refused_in_one_line(tmp_path: Path, text: bytes) -> None:
    path = tmp_path / "a.json"
    path.write_bytes(text)
    with pytest.raises(RecordError, match=r"a\.json is no leaderboard") as caught:
        read_entry(path)
    assert len(str(caught.value).splitlines()) == 1


def test_a_truncated_leaderboard_is_refused(board: LeaderboardRecord, tmp_path: Path) -> None:
    text = board.model_dump_json()
    path = tmp_path / "a.json"
    for length in range(0, len(text), max(1, len(text) // 40)):
        path.write_text(text[:length])
        with pytest.raises(RecordError):
            read_entry(path)


def test_an_oversized_file_is_not_read_to_its_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.json"
    path.write_text(" " * 300)
    monkeypatch.setattr("hhrl_bench.leaderboard.entry.MAX_ENTRY_BYTES", 200)
    with pytest.raises(RecordError, match="larger than"):
        read_entry(path)


def test_a_leaderboard_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(RecordError, match="No such file or directory"):
        read_entry(tmp_path / "a.json")
    with pytest.raises(RecordError, match="Is a directory"):
        read_entry(tmp_path)


def test_an_agent_that_does_not_load_is_said_before_anything_is_played(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(units, "evaluate_agent", lambda *_: pytest.fail("played"))
    broken = ScoreSuite("broken", agents=("rule-1", "rule-9"), tasks=("stop-line-v0",), episodes=3)
    with pytest.raises(AgentError, match="unknown agent 'rule-9'"):
        next(suite_study(broken, Path("none")).run())


@pytest.mark.parametrize("suite", SUITES.values(), ids=SUITES)
def test_a_suite_names_registered_agents_and_tasks(suite: Suite) -> None:
    assert set(suite.agents) <= {*RULES, *ORACLES, *METHODS}
    assert set(suite.tasks) <= set(TASKS)
    (names,) = [[unit.name for stage in suite.stages(Path("none")) for unit in stage]]
    assert len(set(names)) == len(names) >= max(len(suite.agents), len(suite.tasks))
    assert get_suite(suite.id) is suite


OF_TRAFFIC = {"adversary", "platoon"}  # what drives other vehicles than the ego, or all of them


def test_the_quick_suite_plays_every_shipped_method_and_the_papers_rules() -> None:
    parts = {method.ffv.id for method in METHODS.values() if method.ffv}
    learned = set(shipped_methods()) - parts - OF_TRAFFIC
    assert set(SUITES["quick"].agents) == {*RULES, *ORACLES, *learned} - {"rule-4-literal"}


def test_an_unknown_suite_is_told_which_there_are() -> None:
    with pytest.raises(UnknownSuiteError, match="unknown suite 'slow'; known suites: quick"):
        get_suite("slow")


def test_a_repeated_run_leaves_the_published_file_as_it_is(board: LeaderboardRecord, tmp_path: Path) -> None:
    path = tmp_path / "quick.json"
    write_entry(board, path)
    before = path.read_bytes()
    again = board.model_copy(update={"provenance": board.provenance.model_copy(update={"command": "again"})})
    write_entry(again, path)
    assert path.read_bytes() == before
    write_entry(board.model_copy(update={"suite": "other"}), path)
    assert path.read_bytes() != before
    path.write_text("{")
    write_entry(board, path)
    assert path.read_bytes() == before
