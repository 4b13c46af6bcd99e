"""The progress folder: who works in it, how far its units are, and what is refused."""

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hhrl_agents.atomic_files import OutputError
from hhrl_bench.errors import RecordError
from hhrl_bench.execution.progress_folder import ProgressFolder, StudyStatus, UnitStatus
from hhrl_bench.execution.run import Overseer
from hhrl_envs.errors import one_line
from support.command_line import invoke

STUDY = StudyStatus(study="tiny", executor="local", started="2026-01-01T00:00:00+00:00", units=("a", "b on c", "../d"))


@pytest.fixture
def progress(tmp_path: Path) -> ProgressFolder:
    """Return a progress folder that was opened once."""
    progress = ProgressFolder(tmp_path / "progress")
    with progress.opened(STUDY):
        pass
    return progress


def test_what_was_written_is_read(progress: ProgressFolder) -> None:
    assert progress.study() == STUDY
    assert progress.unit("a") is None
    for name in STUDY.units:
        status = UnitStatus(unit=name, state="running", done=1, total=4, note="half", seconds=0.5)
        progress.write(status)
        assert progress.unit(name) == status
        assert status.share == 0.25
    assert all(path.parent == progress.path for path in progress.path.rglob("*"))
    progress.forget("a")
    assert progress.unit("a") is None


def test_a_second_run_is_refused_while_one_is_at_work_and_not_afterwards(progress: ProgressFolder) -> None:
    with progress.opened(STUDY):
        assert progress.is_open()
        with pytest.raises(OutputError, match="another run works in"), progress.opened(STUDY):
            pass
    assert not progress.is_open()
    with progress.opened(STUDY):
        pass


def test_a_new_run_forgets_what_was_said_before_and_what_a_kill_has_left(progress: ProgressFolder) -> None:
    progress.write(UnitStatus(unit="a", state="failed"))
    (progress.path / ".b.unit.json.0123abcd.hhrl.tmp").touch()
    with progress.opened(STUDY):
        assert progress.unit("a") is None
        assert not list(progress.path.glob(".*"))


@contextmanager
def other_process(context: str, path: Path) -> Iterator[subprocess.Popen[str]]:
    """Return a context in which another process holds what ``context`` makes of a progress folder."""
    code = (
        "import sys; from pathlib import Path\n"
        "from hhrl_bench.execution.progress_folder import ProgressFolder, StudyStatus\n"
        "study = StudyStatus(study='tiny', executor='local', started='', units=())\n"
        f"with ProgressFolder(Path({str(path)!r})).{context}: print('held', flush=True); sys.stdin.read()"
    )
    paths = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-c", code]
    with subprocess.Popen(command, env=paths, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == "held\n"
        yield holder
        holder.kill()


def test_a_run_s_lock_ends_with_its_process_even_if_that_is_killed(progress: ProgressFolder) -> None:
    with other_process("opened(study)", progress.path) as holder:
        assert progress.is_open()
        with pytest.raises(OutputError, match="another run works in"), progress.opened(STUDY):
            pass
        holder.kill()
    assert not progress.is_open()
    with progress.opened(STUDY):
        pass


def test_a_run_waits_for_the_processes_of_an_earlier_one(
    progress: ProgressFolder, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hhrl_bench.execution.progress_folder.WORKER_PATIENCE", 0.1)
    with other_process("at_work()", progress.path) as holder:
        with pytest.raises(OutputError, match="processes of an earlier run still work in"), progress.opened(STUDY):
            pass
        with progress.at_work(), progress.at_work():
            pass
        holder.kill()
    with progress.opened(STUDY), progress.at_work():
        assert progress.is_open()
    assert not list(progress.path.glob("*.worker.lock"))


@given(st.text())
def test_any_text_becomes_a_line_that_a_record_takes(text: str) -> None:
    status = UnitStatus(unit="a", state="failed", note=one_line(text))
    assert UnitStatus.model_validate_json(status.model_dump_json()) == status


def test_a_unit_whose_file_stays_the_same_has_stalled(
    progress: ProgressFolder, monkeypatch: pytest.MonkeyPatch
) -> None:
    now = 1000.0
    monkeypatch.setattr("hhrl_bench.execution.run.time.perf_counter", lambda: now)
    shown: list[list[str]] = []
    overseer = Overseer(progress, lambda running: shown.append([one.unit for one in running]), patience=60.0)
    for name in ("a", "b on c"):
        progress.write(UnitStatus(unit=name, state="running", done=1, total=2))
    assert overseer.stalled(STUDY.units) == []
    now += 50.0
    progress.write(UnitStatus(unit="a", state="running", done=2, total=2))
    assert overseer.stalled(STUDY.units) == []
    now += 50.0
    assert overseer.stalled(STUDY.units) == ["b on c"]
    overseer.forget("b on c")
    now += 50.0
    progress.write(UnitStatus(unit="b on c", state="running"))
    assert overseer.stalled(STUDY.units) == ["a"]
    progress.write(UnitStatus(unit="a", state="done"))
    now += 50.0
    assert overseer.stalled(STUDY.units) == []
    assert shown == [["a", "b on c"]] * 4 + [["b on c"]]


def test_status_is_said_of_a_run_at_work_and_of_one_that_was_stopped(progress: ProgressFolder) -> None:
    progress.write(UnitStatus(unit="a", state="running", done=1, total=4, note="validation success 50%", seconds=10.0))
    progress.write(UnitStatus(unit="b on c", state="failed", note="because"))
    with progress.opened(STUDY):
        assert "0 of 3 done, 0 running, 0 failed (local, at work since" in status(progress)
    progress.write(UnitStatus(unit="a", state="running", done=1, total=4, note="validation success 50%", seconds=10.0))
    progress.write(UnitStatus(unit="b on c", state="failed", note="because"))
    said = status(progress)
    assert "suite tiny: 0 of 3 done, 0 running, 1 failed (local, no run is at work)" in said
    assert "stopped; validation success 50%" in said
    assert "because" in said


def status(progress: ProgressFolder) -> str:
    done = invoke("run", "--status", str(progress.path.parent))
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
def test_a_damaged_folder_is_one_line_and_exit_code_2(progress: ProgressFolder, name: str, content: bytes) -> None:
    progress.write(UnitStatus(unit="a", state="done"))
    path = progress.path / name if name != "unit" else next(progress.path.glob("*.unit.json"))
    path.write_bytes(content)
    refuse(progress, str(path.name))


def test_what_is_no_file_is_refused_without_waiting_for_it(progress: ProgressFolder) -> None:
    (progress.path / "study.json").unlink()
    refuse(progress, "no suite was run in")
    os.mkfifo(progress.path / "study.json")
    refuse(progress, "is not a file")


@pytest.mark.parametrize("name", ["study.json", "run.lock", "a.worker.lock", "a.unit.json"])
@pytest.mark.parametrize("make", [os.mkfifo, os.mkdir], ids=["fifo", "folder"])
def test_a_run_refuses_a_folder_in_which_it_cannot_write(
    name: str, make: Callable[[Path], None], progress: ProgressFolder
) -> None:
    path = progress.path / name
    path.unlink(missing_ok=True)
    make(path)
    if name == "a.unit.json" and path.is_fifo():
        with progress.opened(STUDY):
            assert not path.exists()
        return
    with pytest.raises(OSError if name == "a.unit.json" else OutputError), progress.opened(STUDY):
        pass


def test_a_board_in_the_place_of_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "progress").write_text("mine")
    with pytest.raises(OutputError, match="cannot write"), ProgressFolder(tmp_path / "progress").opened(STUDY):
        pass
    assert (tmp_path / "progress").read_text() == "mine"


def test_a_unit_s_file_in_another_s_place_is_refused(progress: ProgressFolder) -> None:
    progress.write(UnitStatus(unit="a", state="done"))
    path = next(progress.path.glob("*.unit.json"))
    path.write_text(UnitStatus(unit="other", state="done").model_dump_json())
    with pytest.raises(RecordError, match="is of another unit"):
        progress.unit("a")


def refuse(progress: ProgressFolder, said: str) -> None:
    done = invoke("run", "--status", str(progress.path.parent))
    assert done.exit_code == 2
    assert done.stdout == ""
    assert len(done.stderr.splitlines()) == 1
    assert said in done.stderr
