"""The board: who works in a folder, how far its units are, and what is refused."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hhrl_agents.atomic_files import OutputError
from hhrl_bench.errors import RecordError
from hhrl_bench.execution.progress_board import Board, StudyStatus, UnitStatus
from hhrl_bench.execution.run import Overseer
from hhrl_bench.locks import is_locked, locked
from hhrl_envs.errors import one_line
from support.command_line import invoke

STUDY = StudyStatus(study="tiny", executor="local", started="2026-01-01T00:00:00+00:00", units=("a", "b on c", "../d"))


@pytest.fixture
def board(tmp_path: Path) -> Board:
    """Return a board that was opened once."""
    board = Board(tmp_path / "progress")
    with board.opened(STUDY):
        pass
    return board


def test_what_was_written_is_read(board: Board) -> None:
    assert board.study() == STUDY
    assert board.unit("a") is None
    for name in STUDY.units:
        status = UnitStatus(unit=name, state="running", done=1, total=4, note="half", seconds=0.5)
        board.write(status)
        assert board.unit(name) == status
        assert status.share == 0.25
    assert all(path.parent == board.folder for path in board.folder.rglob("*"))
    board.forget("a")
    assert board.unit("a") is None


def test_a_second_run_is_refused_while_one_is_at_work_and_not_afterwards(board: Board) -> None:
    with board.opened(STUDY):
        assert board.is_open()
        with pytest.raises(OutputError, match="another run works in"), board.opened(STUDY):
            pass
    assert not board.is_open()
    with board.opened(STUDY):
        pass


def test_a_new_run_forgets_what_was_said_before_and_what_a_kill_has_left(board: Board) -> None:
    board.write(UnitStatus(unit="a", state="failed"))
    (board.folder / ".b.unit.json.7.tmp").touch()
    with board.opened(STUDY):
        assert board.unit("a") is None
        assert not list(board.folder.glob(".*"))


def test_a_lock_ends_with_its_holder_even_if_that_is_killed(tmp_path: Path) -> None:
    path = tmp_path / "a.lock"
    code = (
        "import sys; from pathlib import Path; from hhrl_bench.locks import locked\n"
        f"with locked(Path({str(path)!r}), 'busy'): print('held', flush=True); sys.stdin.read()"
    )
    paths = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-c", code]
    with subprocess.Popen(command, env=paths, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == "held\n"
        assert is_locked(path)
        with pytest.raises(OutputError, match="busy"), locked(path, "busy", patience=0.0):
            pass
        holder.kill()
    assert not is_locked(path)
    with locked(path, "busy", shared=True), locked(path, "busy", shared=True):
        assert is_locked(path) is False  # one asks beside those who share it


@given(st.text())
def test_any_text_becomes_a_line_that_a_record_takes(text: str) -> None:
    status = UnitStatus(unit="a", state="failed", note=one_line(text))
    assert UnitStatus.model_validate_json(status.model_dump_json()) == status


def test_a_unit_whose_file_stays_the_same_has_stalled(board: Board, monkeypatch: pytest.MonkeyPatch) -> None:
    now = 1000.0
    monkeypatch.setattr("hhrl_bench.execution.run.time.perf_counter", lambda: now)
    shown: list[list[str]] = []
    overseer = Overseer(board, lambda running: shown.append([one.unit for one in running]), patience=60.0)
    for name in ("a", "b on c"):
        board.write(UnitStatus(unit=name, state="running", done=1, total=2))
    assert overseer.look(STUDY.units) == []
    now += 50.0
    board.write(UnitStatus(unit="a", state="running", done=2, total=2))
    assert overseer.look(STUDY.units) == []
    now += 50.0
    assert overseer.look(STUDY.units) == ["b on c"]
    overseer.begin_again("b on c")
    now += 50.0
    board.write(UnitStatus(unit="b on c", state="running"))
    assert overseer.look(STUDY.units) == ["a"]
    board.write(UnitStatus(unit="a", state="done"))
    now += 50.0
    assert overseer.look(STUDY.units) == []
    assert shown == [["a", "b on c"]] * 4 + [["b on c"]]


def test_status_is_said_of_a_run_at_work_and_of_one_that_was_stopped(board: Board) -> None:
    board.write(UnitStatus(unit="a", state="running", done=1, total=4, note="validation success 50%", seconds=10.0))
    board.write(UnitStatus(unit="b on c", state="failed", note="because"))
    with board.opened(STUDY):
        assert "0 of 3 done, 0 running, 0 failed (local, at work since" in status(board)
    board.write(UnitStatus(unit="a", state="running", done=1, total=4, note="validation success 50%", seconds=10.0))
    board.write(UnitStatus(unit="b on c", state="failed", note="because"))
    said = status(board)
    assert "suite tiny: 0 of 3 done, 0 running, 1 failed (local, no run is at work)" in said
    assert "stopped; validation success 50%" in said
    assert "because" in said


def status(board: Board) -> str:
    done = invoke("run", "--status", str(board.folder.parent))
    assert done.exit_code == 0, done.stderr
    return done.stdout


HOSTILE = {
    "empty": b"",
    "nothing": b"{}",
    "other": b'{"suite": "quick"}',
    "deep": b"[" * 100_000,
    "binary": bytes(range(256)),
    "escapes": b'{"study": "\\u001b[2J", "executor": "local", "started": "", "units": []}',
    "large": b" " * (16 * 2**20 + 1),
}


@pytest.mark.parametrize("content", HOSTILE.values(), ids=HOSTILE.keys())
@pytest.mark.parametrize("name", ["study.json", "unit"])
def test_a_damaged_folder_is_one_line_and_exit_code_2(board: Board, name: str, content: bytes) -> None:
    board.write(UnitStatus(unit="a", state="done"))
    path = board.folder / name if name != "unit" else next(board.folder.glob("*.unit.json"))
    path.write_bytes(content)
    refuse(board, str(path.name))


def test_what_is_no_file_is_refused_without_waiting_for_it(board: Board) -> None:
    (board.folder / "study.json").unlink()
    refuse(board, "no suite was run in")
    os.mkfifo(board.folder / "study.json")
    refuse(board, "is not a file")


@pytest.mark.parametrize("name", ["study.json", "run.lock", "workers.lock", "a.unit.json"])
@pytest.mark.parametrize("make", [os.mkfifo, os.mkdir], ids=["fifo", "folder"])
def test_a_run_refuses_a_folder_in_which_it_cannot_write(name: str, make: Callable[[Path], None], board: Board) -> None:
    path = board.folder / name
    path.unlink(missing_ok=True)
    make(path)
    if name == "a.unit.json" and path.is_fifo():
        with board.opened(STUDY):
            assert not path.exists()
        return
    with pytest.raises(OSError if name == "a.unit.json" else OutputError), board.opened(STUDY):
        pass


def test_a_board_in_the_place_of_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "progress").write_text("mine")
    with pytest.raises(OutputError, match="cannot write"), Board(tmp_path / "progress").opened(STUDY):
        pass
    assert (tmp_path / "progress").read_text() == "mine"


def test_a_unit_s_file_in_another_s_place_is_refused(board: Board) -> None:
    board.write(UnitStatus(unit="a", state="done"))
    path = next(board.folder.glob("*.unit.json"))
    path.write_text(UnitStatus(unit="other", state="done").model_dump_json())
    with pytest.raises(RecordError, match="is of another unit"):
        board.unit("a")


def refuse(board: Board, said: str) -> None:
    done = invoke("run", "--status", str(board.folder.parent))
    assert done.exit_code == 2
    assert done.stdout == ""
    assert len(done.stderr.splitlines()) == 1
    assert said in done.stderr
