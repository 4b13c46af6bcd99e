"""Publishing: entries verified before they are indexed or submitted, nothing half-done, everything else refused."""

import json
import os
import shutil
from pathlib import Path

import pytest

from hhrl_bench.evaluation.store import Store
from hhrl_bench.leaderboard.entry import entry_schema, publish_entry, read_entry
from hhrl_bench.publishing import memory, publication
from hhrl_bench.publishing.copies import Stored
from hhrl_bench.publishing.publication import IndexRecord
from hhrl_bench.suites import suites
from hhrl_bench.suites.suites import ScoreSuite
from support.command_line import invoke

TINY = ScoreSuite("tiny", agents=("rule-1", "rule-plus"), tasks=("stop-line-v0", "solo-stop-v0"), episodes=20)
OWN = "import hhrl_agents\n\n\ndef make(scenario):\n    return hhrl_agents.RULES['rule-tuned'](scenario)\n"
COPY = """
import numpy as np
from hhrl_agents import RULES, Decision


class Copy:
    def __init__(self, scenario):
        self._rule = RULES["rule-plus"](scenario)

    def reset(self, mask):
        self._rule.reset(mask)

    def act(self, observations):
        action = self._rule.act(observations).action
        return Decision(np.zeros(len(action), np.int64), action)


make = Copy
"""


@pytest.fixture(autouse=True)
def tiny(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(suites, "SUITES", {"tiny": TINY})


@pytest.fixture(autouse=True)
def nothing_remembered(monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the entry of the tiny suite and its files."""
    folder = tmp_path_factory.mktemp("made")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(suites, "SUITES", {"tiny": TINY})
        paths = ("--out", str(folder / "board" / "tiny.json"), "--work", str(folder / "work"), "--workers", "1")
        assert invoke("run", "--suite", "tiny", *paths).exit_code == 0
    return folder / "board"


@pytest.fixture
def folder(made: Path, tmp_path: Path) -> Path:
    return shutil.copytree(made, tmp_path / "published")


def tree(folder: Path) -> dict[str, bytes]:
    """Return every file in a folder."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def own_entry(folder: Path, monkeypatch: pytest.MonkeyPatch, name: str = "my_rule", code: str = OWN) -> Path:
    """Return the entry of a user's own agent."""
    (folder / f"{name}.py").write_text(code)
    monkeypatch.chdir(folder)
    out = folder / "mine" / "entry.json"
    paths = ("--out", str(out), "--work", str(folder / "work"), "--workers", "1")
    result = invoke("run", "--suite", "tiny", "--agent", f"{name}:make", *paths)
    assert result.exit_code == 0, result.stderr
    return out


def test_a_folder_is_built_once_and_then_verified(folder: Path) -> None:
    assert invoke("leaderboard", "verify", str(folder)).exit_code == 2  # no index yet
    assert invoke("leaderboard", "build", "--folder", str(folder)).exit_code == 0
    index = IndexRecord.model_validate_json((folder / "INDEX.json").read_bytes())
    (entry,) = index.entries
    assert (entry.file, entry.suite, entry.agents, entry.results) == ("tiny.json", "tiny", TINY.agents, 4)
    assert entry.verified.level == "replayed"
    assert (folder / "schema.json").read_text() == entry_schema()
    before = tree(folder)
    assert invoke("leaderboard", "build", "--folder", str(folder)).exit_code == 0
    assert tree(folder) == before
    result = invoke("leaderboard", "verify", str(folder), "--level", "rerun", "--sample", "1", "--fresh", "30")
    assert result.exit_code == 0, result.stdout
    assert "tiny.json: rerun" in result.stdout
    result = invoke("leaderboard", "verify", str(folder), "--sample", "1")
    said = (
        "hhrl-bench: Invalid value for --sample: --level replayed runs no agent again; "
        "write --level rerun or --level retrained\n"
    )
    assert (result.exit_code, result.stdout, result.stderr) == (2, "", said)


def test_what_does_not_hold_is_named_and_nothing_is_written(folder: Path) -> None:
    path = folder / "tiny.json"
    board = json.loads(path.read_text())
    board["results"][0]["runs"][0]["metrics"]["not_stop"] = 0.5
    path.write_text(json.dumps(board))
    before = tree(folder)
    result = invoke("leaderboard", "build", "--folder", str(folder))
    assert result.exit_code == 1
    assert "results[0].runs[0].metrics.not_stop: 0.5 is published, 1.0 was found" in result.stdout
    assert tree(folder) == before
    told = json.loads(invoke("leaderboard", "verify", str(path), "--json").stdout)
    assert told["verified"] == {}
    assert told["findings"][0]["place"] == "results[0].runs[0].metrics.not_stop"
    assert len({str(one) for one in told["findings"]}) == len(told["findings"])


def test_the_index_alone_is_no_entry(folder: Path) -> None:
    assert invoke("leaderboard", "build", "--folder", str(folder)).exit_code == 0
    told = json.loads(invoke("leaderboard", "verify", str(folder), "--json").stdout)
    assert told == {"level": "replayed", "verified": {str(folder / "tiny.json"): "replayed"}, "findings": []}
    result = invoke("leaderboard", "verify", str(folder / "INDEX.json"))
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr == f"hhrl-bench: {folder / 'INDEX.json'} is the index of a folder of entries; name an entry\n"


def test_an_entry_of_an_unknown_task_hides_no_other(folder: Path) -> None:
    shutil.copy(folder / "tiny.json", folder / "other.json")
    assert invoke("leaderboard", "build", "--folder", str(folder)).exit_code == 0
    (folder / "other.json").write_text((folder / "other.json").read_text().replace("solo-stop-v0", "solo-stop-v9"))
    result = invoke("leaderboard", "verify", str(folder))
    assert result.exit_code == 1
    assert f"{folder / 'other.json'}: tasks: unknown task 'solo-stop-v9'" in result.stdout
    assert f"{folder / 'tiny.json'}: replayed" in result.stdout


def test_the_index_tells_of_other_entries_and_of_files_that_no_entry_names(folder: Path) -> None:
    assert invoke("leaderboard", "build", "--folder", str(folder)).exit_code == 0
    shutil.copy(folder / "tiny.json", folder / "other.json")
    (folder / "evidence" / "stray").touch()
    result = invoke("leaderboard", "verify", str(folder))
    assert result.exit_code == 1
    assert "INDEX.json: it lacks other.json; hhrl-bench leaderboard build adds it" in result.stdout
    assert "evidence/stray: no entry names this file" in result.stdout


def test_an_own_agent_is_scored_and_submitted(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    entry = own_entry(tmp_path, monkeypatch)
    result = invoke("leaderboard", "submit", str(entry), "--name", "my-rule", "--folder", str(folder))
    assert result.exit_code == 0, result.stdout
    assert invoke("leaderboard", "build", "--folder", str(folder)).exit_code == 0
    assert list(publication.of_suite(folder, "tiny")) == ["tiny", "my-rule"]
    said = invoke("leaderboard", "verify", str(folder / "my-rule.json"), "--level", "rerun", "--fresh", "5")
    assert (said.exit_code, said.stdout) == (0, f"{folder / 'my-rule.json'}: replayed\n")
    assert "2 of 2 results were not run: they are a user's own code" in said.stderr
    assert invoke("leaderboard", "build", "--folder", str(folder), "--level", "rerun").exit_code == 0
    index = IndexRecord.model_validate_json((folder / "INDEX.json").read_bytes())
    assert {one.file: one.verified.level for one in index.entries} == {"my-rule.json": "replayed", "tiny.json": "rerun"}
    (mine, _) = read_entry(folder / "my-rule.json").results
    assert (mine.agent, mine.kind) == ("my_rule:make", "factory")
    again = invoke("leaderboard", "submit", str(entry), "--name", "my-rule", "--folder", str(folder))
    assert again.exit_code == 2
    assert "holds an entry my-rule already; write another --name" in again.stderr


def test_episodes_of_a_published_agent_are_not_submitted_under_another_name(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    entry, before = own_entry(tmp_path, monkeypatch, "my_copy", COPY), tree(folder)
    result = invoke("leaderboard", "submit", str(entry), "--name", "mine", "--folder", str(folder))
    assert result.exit_code == 2
    assert "100% of its episodes are those of rule-plus in tiny.json; submit another agent's" in result.stderr
    assert tree(folder) == before
    published = Stored(read_entry(entry), Store(entry.parent))
    publish_entry(published.board, folder / "mine.json", published.store)
    built = invoke("leaderboard", "build", "--folder", str(folder))
    assert built.exit_code == 1
    assert f"{folder}: mine.json results[0].runs[0].evidence_sha256: 100% of its episodes" in built.stdout


def test_what_does_not_verify_is_not_submitted(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    entry = own_entry(tmp_path, monkeypatch, "my_other")
    entry.write_text(entry.read_text().replace('"success": 1.0', '"success": 0.9'))
    before = tree(folder)
    result = invoke("leaderboard", "submit", str(entry), "--name", "mine", "--folder", str(folder))
    assert result.exit_code == 1
    assert "nothing was submitted" in result.stderr
    assert tree(folder) == before


@pytest.mark.parametrize("name", ["../escape", "tiny", "Upper", "", "a/b", "x" * 70, "INDEX", "schema"])
def test_a_bad_name_is_refused(folder: Path, name: str) -> None:
    before = tree(folder.parent)
    path = str(folder / "tiny.json")
    result = invoke("leaderboard", "submit", path, "--name", name, "--folder", str(folder))
    assert result.exit_code == 2
    assert f"cannot call an entry {name!r}" in result.stderr
    assert tree(folder.parent) == before


def test_an_entry_that_its_suite_does_not_make_is_refused(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for other in (
        ScoreSuite("tiny", TINY.agents, TINY.tasks, 30),
        ScoreSuite("tiny", TINY.agents, TINY.tasks[:1], 20),
    ):
        monkeypatch.setattr(suites, "SUITES", {"tiny": other})
        result = invoke("leaderboard", "submit", str(folder / "tiny.json"), "--name", "a", "--folder", str(folder))
        assert result.exit_code == 2
        assert "hhrl-bench run --suite tiny makes one" in result.stderr


def test_what_is_published_already_is_refused(folder: Path) -> None:
    result = invoke("leaderboard", "submit", str(folder / "tiny.json"), "--name", "twin", "--folder", str(folder))
    assert result.exit_code == 2
    assert "tiny.json already; submit another agent's" in result.stderr
    assert not (folder / "twin.json").exists()


def test_all_commands_refuse_a_folder_with_a_file_that_is_not_named_as_an_entry(folder: Path, made: Path) -> None:
    assert invoke("leaderboard", "build", "--folder", str(folder)).exit_code == 0
    (folder / "My Entry.json").write_bytes((folder / "tiny.json").read_bytes())
    before = tree(folder)
    submit = ("submit", str(made / "tiny.json"), "--name", "twin", "--folder", str(folder))
    for command in (("verify", str(folder)), ("build", "--folder", str(folder)), submit):
        result = invoke("leaderboard", *command)
        assert result.exit_code == 2
        assert f"{folder / 'My Entry.json'} is not named as an entry; write small letters" in result.stderr
    assert tree(folder) == before


def test_what_a_killed_writer_has_left_is_in_no_reader_s_way(folder: Path) -> None:
    assert invoke("leaderboard", "build", "--folder", str(folder)).exit_code == 0
    for path in (folder / "tiny.json", next((folder / "evidence").iterdir())):
        path.with_name(f".{path.name}.0123abcd.hhrl.tmp").write_bytes(path.read_bytes()[:9])
    result = invoke("leaderboard", "verify", str(folder))
    assert (result.exit_code, result.stdout.splitlines()[0]) == (
        0,
        f"{folder / 'INDEX.json'}: names every entry and file",
    )


@pytest.mark.parametrize("command", [("leaderboard", "show"), ("leaderboard", "verify"), ("report",), ("figures",)])
def test_the_files_beside_the_entries_are_refused_as_what_they_are(folder: Path, command: tuple[str, ...]) -> None:
    assert invoke("leaderboard", "build", "--folder", str(folder)).exit_code == 0
    for name, what in (("INDEX.json", "the index"), ("schema.json", "the schema")):
        result = invoke(*command, str(folder / name))
        assert (result.exit_code, result.stdout) == (2, "")
        assert result.stderr == f"hhrl-bench: {folder / name} is {what} of a folder of entries; name an entry\n"


def test_a_folder_without_entries_is_one_line(tmp_path: Path) -> None:
    for command in (("verify", str(tmp_path)), ("build", "--folder", str(tmp_path))):
        result = invoke("leaderboard", *command)
        assert result.exit_code == 2
        assert len(result.stderr.splitlines()) == 1


def built(folder: Path, *words: str) -> str:
    """Return what a build that succeeds says of its work."""
    result = invoke("leaderboard", "build", "--folder", str(folder), *words)
    assert result.exit_code == 0, result.stdout
    return result.stderr


UNCHANGED = "nothing has changed since"


def test_a_build_verifies_again_only_what_has_changed(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copy(folder / "tiny.json", folder / "other.json")
    assert UNCHANGED not in built(folder)
    index = (folder / "INDEX.json").read_bytes()
    said = built(folder)
    assert said.count(UNCHANGED) == 2
    assert "verify tiny.json" not in said
    assert (folder / "INDEX.json").read_bytes() == index
    assert UNCHANGED not in built(folder, "--again")
    assert UNCHANGED not in built(folder, "--level", "recomputed"), "another level is another thing to verify"
    (folder / "other.json").write_text((folder / "other.json").read_text().replace('"created": "2', '"created": "1'))
    said = built(folder)
    assert (said.count(UNCHANGED), "verify other.json" in said) == (1, True)
    monkeypatch.setattr(memory, "software", lambda: {"numpy": "another one"})
    assert UNCHANGED not in built(folder)


def test_what_does_not_hold_is_not_passed_over_because_it_once_held(folder: Path) -> None:
    built(folder)
    (evidence, *_) = sorted((folder / "evidence").iterdir())
    whole = evidence.read_bytes()
    evidence.write_bytes(whole[:-1])
    assert invoke("leaderboard", "build", "--folder", str(folder)).exit_code == 1
    assert invoke("leaderboard", "build", "--folder", str(folder)).exit_code == 1
    evidence.write_bytes(whole)
    assert UNCHANGED in built(folder)


def test_no_folder_of_entries_says_of_itself_that_it_was_verified(folder: Path) -> None:
    built(folder)
    (known,) = (Path(os.environ["XDG_CACHE_HOME"]) / "hhrl-bench" / "verified").iterdir()
    known.rename(folder / "verified.json.txt")
    assert UNCHANGED not in built(folder)
    (known,) = (Path(os.environ["XDG_CACHE_HOME"]) / "hhrl-bench" / "verified").iterdir()
    known.write_text("{}")
    assert UNCHANGED not in built(folder)


def test_without_a_cache_everything_is_verified(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    for _ in range(2):
        assert UNCHANGED not in built(folder)


def test_results_are_checked_side_by_side_to_the_same_words(folder: Path) -> None:
    text = (folder / "tiny.json").read_text()
    (folder / "tiny.json").write_text(text.replace('"not_stop": 1.0', '"not_stop": 0.5').replace("rule-plus", "rule-2"))
    words = ("leaderboard", "verify", str(folder / "tiny.json"), "--level", "rerun", "--json")
    alone, beside = invoke(*words), invoke(*words, "--jobs", "3")
    assert (beside.exit_code, beside.stdout) == (alone.exit_code, alone.stdout) == (1, alone.stdout)
    assert len(json.loads(alone.stdout)["findings"]) >= 3
    lines = [[line for line in one.stderr.splitlines() if line.startswith("verify ")] for one in (alone, beside)]
    assert lines[0] == lines[1]
