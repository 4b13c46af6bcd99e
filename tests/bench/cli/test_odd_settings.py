"""What a process inherits from its surroundings does not end a command in a traceback."""

import subprocess
import sys
from pathlib import Path

import pytest

from support.sweeps import environment


def evaluate(folder: Path, *options: str, **settings: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, *options, "-m", "hhrl_bench", "evaluate", "rule-4", "--episodes", "1"]
    return subprocess.run(command, cwd=folder, env=environment(**settings), capture_output=True, text=True, check=False)


@pytest.mark.parametrize("number", ["0", "many"])
def test_a_number_of_threads_that_is_none_is_refused_in_one_line(number: str, tmp_path: Path) -> None:
    ended = evaluate(tmp_path, NUMBA_NUM_THREADS=number)
    assert ended.returncode == 2
    assert ended.stderr == (
        f"hhrl-bench: Invalid value: NUMBA_NUM_THREADS is '{number}'; write a number of threads from 1, or unset it\n"
    )


def test_warnings_as_errors_missing_folders_and_a_narrow_terminal_do_not_matter(tmp_path: Path) -> None:
    gone = str(tmp_path / "gone")
    settings = {"HOME": gone, "TMPDIR": gone, "COLUMNS": "20", "TERM": "dumb", "LC_ALL": "C", "PYTHONUTF8": "0"}
    ended = evaluate(tmp_path, "-W", "error", **settings)
    assert ended.returncode == 0, ended.stderr
    assert "rule-4" in ended.stdout


def test_a_current_folder_that_is_gone_is_said(tmp_path: Path) -> None:
    folder = tmp_path / "gone"
    folder.mkdir()
    code = "import os, sys; os.rmdir(os.getcwd()); import hhrl_bench.cli; hhrl_bench.cli.main()"
    command = [sys.executable, "-c", code, "evaluate", "rule-4", "--episodes", "1"]
    ended = subprocess.run(command, cwd=folder, env=environment(), capture_output=True, text=True, check=False)
    assert ended.returncode == 2
    assert ended.stderr == "hhrl-bench: the current folder has been removed; change to one that is there\n"
