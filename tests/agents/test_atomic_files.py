import os
import stat
import time
from pathlib import Path

import pytest

from hhrl_agents.atomic_files import (
    FRAGMENT_SECONDS,
    OutputError,
    filled_folder,
    is_fragment,
    remove_fragments,
    require_writable,
    write_atomically,
    write_folder_atomically,
)


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_text_and_bytes_take_the_place_of_what_was_there(tmp_path: Path) -> None:
    write_atomically(tmp_path / "a", "ä\n")
    write_atomically(tmp_path / "a", b"\x00")
    assert (tmp_path / "a").read_bytes() == b"\x00"
    assert names(tmp_path) == ["a"]


def test_a_failed_write_leaves_what_was_there_and_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    (tmp_path / "a").write_text("before")
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OutputError, match=r"cannot write .*a: No space left on device"):
        write_atomically(tmp_path / "a", "after")
    assert (tmp_path / "a").read_text() == "before"
    assert names(tmp_path) == ["a"]


def test_a_file_is_on_the_disk_before_it_has_its_name_and_then_its_folder_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    done: list[str] = []
    replace = Path.replace

    def synced(descriptor: int) -> None:
        done.append("folder" if stat.S_ISDIR(os.fstat(descriptor).st_mode) else f"{os.fstat(descriptor).st_size} bytes")

    def replaced(path: Path, target: Path) -> Path:
        done.append("name")
        return replace(path, target)

    monkeypatch.setattr(os, "fsync", synced)
    monkeypatch.setattr(Path, "replace", replaced)
    write_atomically(tmp_path / "a", "after")
    assert done == ["5 bytes", "name", "folder"]


def test_what_cannot_be_written_is_said_before_the_work(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for path in (tmp_path / "file" / "a", tmp_path / "file" / "b" / "a", tmp_path, Path("/dev/null")):
        with pytest.raises(OutputError, match="cannot write"):
            require_writable(path)
    assert names(tmp_path) == ["file"]


def test_a_try_leaves_neither_file_nor_folder(tmp_path: Path) -> None:
    require_writable(tmp_path / "new" / "newer" / "a")
    assert names(tmp_path) == []
    (tmp_path / "old").mkdir()
    require_writable(tmp_path / "old" / "a")
    assert names(tmp_path / "old") == []


def test_the_folder_of_a_file_is_made_with_it_or_not_at_all(tmp_path: Path) -> None:
    write_atomically(tmp_path / "new" / "newer" / "a", "text")
    assert names(tmp_path / "new" / "newer") == ["a"]
    with pytest.raises(OutputError, match="cannot write"):
        write_atomically(tmp_path / "other" / "newer" / ("a" * 300), "text")
    assert names(tmp_path) == ["new"]


def test_a_folder_is_filled_at_once_or_not_at_all(tmp_path: Path) -> None:
    with filled_folder(tmp_path / "new") as new:
        (new / "a").write_text("a")
        assert not (tmp_path / "new" / "a").exists()
        (new / "b").write_text("b")
    assert names(tmp_path / "new") == ["a", "b"]
    for folder, kept in (("new", ["a", "b"]), ("other", [])):
        with pytest.raises(FileNotFoundError), filled_folder(tmp_path / folder) as new:
            (new / "c").write_text("c"), (new / "nowhere" / "d").write_text("d")
        assert names(tmp_path / folder) == kept if kept else not (tmp_path / folder).exists()


def test_an_interrupt_leaves_what_was_there_and_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(path: Path, _: Path) -> None:
        assert is_fragment(path)
        assert path.exists()
        raise KeyboardInterrupt

    (tmp_path / "a").write_text("before")
    monkeypatch.setattr(Path, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_atomically(tmp_path / "a", "after")
    assert (tmp_path / "a").read_text() == "before"
    assert names(tmp_path) == ["a"]


def leave(path: Path, age: float) -> None:
    """Leave a file that was written so many seconds ago."""
    path.touch()
    os.utime(path, (time.time() - age,) * 2)


def test_the_next_writer_removes_old_fragments_alone(tmp_path: Path) -> None:
    leave(tmp_path / ".a.0123abcd.hhrl.tmp", FRAGMENT_SECONDS + 60.0)
    others = [".b.89abcdef.hhrl.tmp", ".a.tmp", ".a.0123.hhrl.tmp", "a.0123abcd.hhrl.tmp"]
    for name, age in zip(others, (FRAGMENT_SECONDS - 60.0, 10**6, 10**6, 10**6), strict=True):
        leave(tmp_path / name, age)
    write_atomically(tmp_path / "c", "")
    assert names(tmp_path) == sorted([*others, "c"])


def test_who_alone_writes_a_file_may_remove_its_fragments_at_once(tmp_path: Path) -> None:
    for name in (".a.0123abcd.hhrl.tmp", ".b.0123abcd.hhrl.tmp", "a"):
        (tmp_path / name).touch()
    remove_fragments(tmp_path, of="a")
    assert names(tmp_path) == [".b.0123abcd.hhrl.tmp", "a"]
    remove_fragments(tmp_path)
    assert names(tmp_path) == ["a"]


def test_a_folder_is_there_whole_or_not_at_all(tmp_path: Path) -> None:
    def fill(folder: Path) -> None:
        (folder / "inside").mkdir()
        (folder / "inside" / "file").write_text("content")

    def fail(folder: Path) -> None:
        fill(folder)
        raise ZeroDivisionError

    write_folder_atomically(tmp_path / "new" / "made", fill)
    assert (tmp_path / "new" / "made" / "inside" / "file").read_text() == "content"
    with pytest.raises(OutputError, match="cannot write"):
        write_folder_atomically(tmp_path / "new" / "made", fill)
    with pytest.raises(ZeroDivisionError):
        write_folder_atomically(tmp_path / "new" / "other", fail)
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["made"]


def test_what_a_kill_has_left_of_a_folder_is_removed(tmp_path: Path) -> None:
    left = tmp_path / ".made.0123abcd.hhrl.tmp"
    (left / "inside").mkdir(parents=True)
    remove_fragments(tmp_path)
    assert not left.exists()
