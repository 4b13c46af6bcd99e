"""Verification: whatever is changed in an entry or its files is found, and the place is named."""

import contextlib
import json
import re
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("torch")

from hhrl_bench.evaluation.evidence import unpack
from hhrl_bench.evaluation.store import Store, read
from hhrl_bench.leaderboard.entry import MAX_ENTRY_BYTES, check_spelling, read_entry, write_entry
from hhrl_bench.leaderboard.findings import Finding
from hhrl_bench.leaderboard.level import Level
from hhrl_bench.verification.verify import verify
from hhrl_envs.errors import InputError
from support import small_board
from support.command_line import invoke
from support.mutations import Place, at, leaves, other, put

LEVELS = (Level.RECOMPUTED, Level.REPLAYED)

UNPROVABLE = {
    "suite": "a name of the entry's own; to submit it, its tasks and agents have to be that suite's",
    "provenance": "what may differ between two runs: the clock, the machine, the versions",
}
"""What nothing else in an entry says, and so nothing can prove."""


@pytest.fixture(scope="module", autouse=True)
def few_resamples() -> Iterator[None]:
    """Intervals that are quicker to compute, and as easily changed."""
    with small_board.resamples(99):
        yield


@pytest.fixture(scope="module")
def published(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return small_board.publish(tmp_path_factory.mktemp("board"))


@pytest.fixture(scope="module")
def data(published: Path) -> Any:
    return json.loads(published.read_text())


@pytest.fixture
def path(published: Path, tmp_path: Path) -> Path:
    """The path of a copy of the entry, with its files."""
    shutil.copytree(published.parent, tmp_path / "copy")
    return tmp_path / "copy" / published.name


def findings(path: Path, level: Level = Level.REPLAYED) -> list[Finding]:
    return list(verify(read_entry(path), Store(path.parent), level))


def complaint(path: Path) -> str:
    """Return what is said first of an entry that does not hold; nothing if it is taken to hold."""
    try:
        for level in LEVELS:
            if found := findings(path, level):
                return "\n".join(map(str, found))
    except InputError as error:
        return str(error)
    return ""


COMPUTED = {"results": "comparisons", "tasks": "results", "trainings": "efficiency"}
"""Where a number of each part of an entry is used for others."""


def names(said: str, place: Place, value: object) -> bool:
    """Return whether a complaint names a place, what stands there now, or a part that was computed from it."""
    top = str(place[0])
    own = f"{top}[{place[1]}]" if top in {"results", "tasks"} else top
    lines = said.rsplit("is no leaderboard: ", maxsplit=1)[-1].splitlines()
    if any(line.startswith((own, COMPUTED.get(top, own))) for line in lines):
        return True
    return ".".join(map(str, place[:2])) in said or (isinstance(value, str) and value in said)


@pytest.mark.parametrize("level", [level for level in Level if level != Level.RETRAINED])  # see test_retrained.py
def test_what_was_published_holds(published: Path, level: Level) -> None:
    assert findings(published, level) == []
    assert list(check_spelling(published, read_entry(published))) == []


def drawn(data: Any, count: int, seed: int) -> list[Place]:
    """Return that many places of an entry of which something can be proved, some of every part."""
    rng = np.random.default_rng(seed)
    places = [place for place in leaves(data) if place[0] not in UNPROVABLE]
    parts = [[place for place in places if place[0] == part] for part in dict.fromkeys(place[0] for place in places)]
    some = [part[i] for part in parts for i in rng.choice(len(part), min(2, len(part)), replace=False)]
    return [*some, *(places[i] for i in rng.choice(len(places), count, replace=False))]


def test_any_changed_leaf_is_found_and_named(path: Path, data: Any) -> None:
    rng = np.random.default_rng(0)
    for place in drawn(data, count=25, seed=1):
        value = other(at(data, place), rng)
        path.write_text(json.dumps(put(data, place, value)))
        said = complaint(path)
        assert said, f"{place} changed to {value!r} was not found"
        assert names(said, place, value), f"{place} changed to {value!r}: {said}"


def test_any_changed_leaf_of_a_transfer_is_found_and_named(path: Path) -> None:
    write_entry(small_board.with_transfer(read_entry(path), Store(path.parent)), path)
    assert findings(path) == []
    data, rng = json.loads(path.read_text()), np.random.default_rng(3)
    places = [place for place in leaves(data) if place[0] in {"transfer", "checkpoints_published"}]
    for index in rng.choice(len(places), 15, replace=False):
        value = other(at(data, places[index]), rng)
        path.write_text(json.dumps(put(data, places[index], value)))
        assert names(complaint(path), places[index], value), f"{places[index]} changed to {value!r}: {complaint(path)}"


def test_of_checkpoints_that_are_not_published_nothing_is_proved(path: Path) -> None:
    """An entry of a transfer says so itself; its command trains them again."""
    write_entry(small_board.with_transfer(read_entry(path), Store(path.parent)), path)
    data = json.loads(path.read_text())
    path.write_text(json.dumps(put(data, ("results", 4, "runs", 0, "checkpoint_sha256"), "0" * 64)))
    assert complaint(path) == ""


def test_what_cannot_be_proved_is_known(path: Path, data: Any) -> None:
    for place in (("suite",), ("provenance", "command"), ("provenance", "hardware", "cores")):
        path.write_text(json.dumps(put(data, place, 77 if place[-1] == "cores" else "other")))
        assert place[0] in UNPROVABLE
        assert complaint(path) == ""


def test_digits_that_change_no_number_are_found(path: Path) -> None:
    text = path.read_text()
    number = next(line for line in text.splitlines() if '"mean": 0.' in line)
    path.write_text(text.replace(number, number.rstrip(",") + "0" * 20 + ("," if number.endswith(",") else "")))
    board = read_entry(path)
    assert list(verify(board, Store(path.parent), Level.RECOMPUTED)) == []
    (finding,) = check_spelling(path, board)
    assert finding.place.startswith("line ")


def test_any_changed_byte_of_a_file_is_found_and_named(path: Path) -> None:
    rng = np.random.default_rng(2)
    files = sorted(file for file in path.parent.rglob("*") if file.suffix in {".gz", ".safetensors"})
    for file in rng.choice(np.array(files, object), 5, replace=False):
        whole = file.read_bytes()
        flipped = bytearray(whole)
        flipped[rng.integers(len(whole))] ^= int(rng.integers(1, 256))
        file.write_bytes(bytes(flipped))
        said = [str(finding) for finding in findings(path, Level.RECOMPUTED)]
        assert any(file.name in line and line.startswith("results[") for line in said)
        file.write_bytes(whole)


@pytest.mark.parametrize("level", [Level.RECOMPUTED, Level.RERUN])
def test_a_checkpoint_that_is_not_there_hides_nothing_else(path: Path, data: Any, level: Level) -> None:
    for checkpoint in (path.parent / "checkpoints").iterdir():
        checkpoint.unlink()
    path.write_text(path.read_text().replace(f'"n": {data["results"][0]["metrics"]["success"]["n"]}', '"n": 7'))
    places = [finding.place for finding in findings(path, level)]
    assert any(place.endswith("checkpoint_sha256") for place in places)
    assert any(place.startswith("results[0].metrics.") and place.endswith(".n") for place in places)


def replace_evidence(path: Path, data: Any, result: int, **arrays: Any) -> None:
    """Give a result's first run evidence that differs in some arrays, under the hash of what it then is."""
    store, place = Store(path.parent), ("results", result, "runs", 0, "evidence_sha256")
    kept = unpack(read(store.evidence(at(data, place))))
    path.write_text(json.dumps(put(data, place, store.add_evidence(small_board.repacked(kept._replace(**arrays))))))


def test_evidence_that_only_its_own_decisions_contradict_is_found(path: Path, data: Any) -> None:
    """The order of the outcomes changes no mean, but the intervals of paired differences."""
    kept = unpack(read(Store(path.parent).evidence(at(data, ("results", 0, "runs", 0, "evidence_sha256")))))
    turned = kept.outcome[::-1].copy()
    assert not np.array_equal(turned, kept.outcome)
    replace_evidence(path, data, 0, outcome=turned)
    said = [str(finding) for finding in findings(path)]
    assert "results[0].runs[0].evidence_sha256: the outcome in it are not what the decisions in it come to" in said


def test_a_held_option_that_was_not_held_is_found(path: Path, data: Any) -> None:
    path.write_text(json.dumps(put(data, ("results", 0, "option"), "follow")))
    assert [finding.place for finding in findings(path, Level.RECOMPUTED)] == ["results[0].option"]


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (("tasks", 2, "opponent", "agent"), "trap:make"),
        (("results", 4, "agent"), "trap:make"),
        (("results", 5, "agent"), "trap:make"),
    ],
)
def test_nothing_that_an_entry_names_is_executed(
    path: Path, data: Any, place: Place, value: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "trap.py").write_text("from pathlib import Path\nPath('sprung').touch()\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    path.write_text(json.dumps(put(data, place, value)))
    with contextlib.suppress(InputError):
        assert findings(path, Level.RERUN)
    assert not (tmp_path / "sprung").exists()


def tree(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


SPOILT = {
    "truncated": lambda text: text[: len(text) // 2],
    "of another version": lambda text: text.replace('"schema_version": 1', '"schema_version": 2', 1),
    "nested": lambda text: text.replace('"suite": ', '"suite": ' + "[" * 100_000, 1),
    "oversized": lambda text: text + " " * MAX_ENTRY_BYTES,
    "escaping": lambda text: re.sub(r'"evidence_sha256": "[0-9a-f]{64}"', '"evidence_sha256": "../../escape"', text),
    "a terminal's command": lambda text: text.replace('"suite": "', '"suite": "\\u001b[2J', 1),
    "empty": lambda text: text[:0],
}


@pytest.mark.parametrize("spoil", SPOILT.values(), ids=SPOILT)
@pytest.mark.parametrize("command", ["verify", "show", "submit"])
def test_a_spoilt_entry_is_one_line_and_exit_code_2(path: Path, spoil: Callable[[str], str], command: str) -> None:
    path.write_text(spoil(path.read_text()))
    before = tree(path.parent.parent)
    more = ["--name", "mine", "--folder", str(path.parent)] if command == "submit" else []
    said = invoke("leaderboard", command, str(path), *more)
    assert (said.exit_code, said.stdout) == (2, "")
    assert len(said.stderr.splitlines()) == 1
    assert tree(path.parent.parent) == before
