"""What is an entry in a folder of them is told by its name alone."""

from pathlib import Path

import pytest

from hhrl_bench.errors import RecordError
from hhrl_bench.leaderboard.entry_files import entry_paths, find_entries, is_entry_name


def test_entries_are_the_json_files_that_are_so_named(tmp_path: Path) -> None:
    others = ("INDEX.json", "schema.json", "._quick.json", ".quick.json.0123abcd.hhrl.tmp", "quick.html", "quick.md")
    for name in (*others, "quick.json", "4th-entry.json"):
        (tmp_path / name).touch()
    assert [path.name for path in find_entries(tmp_path)] == ["4th-entry.json", "quick.json"]
    assert entry_paths(tmp_path) == find_entries(tmp_path)


@pytest.mark.parametrize("name", ["Quick", "my entry", "-a", "a.b", "x" * 62, "ä"])
def test_another_json_file_is_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / "quick.json").touch()
    (tmp_path / f"{name}.json").touch()
    assert not is_entry_name(name)
    with pytest.raises(RecordError, match="is not named as an entry; write small letters, digits and hyphens"):
        find_entries(tmp_path)


def test_a_folder_may_hold_no_entry_unless_one_is_asked_for(tmp_path: Path) -> None:
    (tmp_path / "INDEX.json").touch()
    assert find_entries(tmp_path) == []
    with pytest.raises(RecordError, match="holds no entry"):
        entry_paths(tmp_path)
