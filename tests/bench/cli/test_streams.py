"""Commands do what was asked for whatever their standard streams are: closed, or of an encoding that lacks signs."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from support.sweeps import environment

COMMAND = [sys.executable, "-m", "hhrl_bench"]


def closed(words: str, redirection: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Return how a command ends that a shell begins with closed streams."""
    line = " ".join([*COMMAND, words, redirection])
    return subprocess.run(
        ["/bin/sh", "-c", line], cwd=folder, env=environment(), capture_output=True, text=True, check=False
    )


@pytest.mark.skipif(os.name != "posix", reason="the shell's redirections")
@pytest.mark.parametrize("redirection", [">&-", "2>&-", "<&- >&- 2>&-"])
def test_closed_streams_do_not_matter(redirection: str, tmp_path: Path) -> None:
    ended = closed("list agents", redirection, tmp_path)
    assert ended.returncode == 0
    assert ended.stderr == ""
    assert ("rule-4" in ended.stdout) == (">&- " not in f"{redirection} ".replace("2>&- ", ""))


@pytest.mark.skipif(os.name != "posix", reason="the shell's redirections")
def test_nothing_is_written_into_files_that_are_opened_in_the_place_of_closed_streams(tmp_path: Path) -> None:
    code = (
        "import os; from hhrl_bench.cli.streams import mend_streams; mend_streams(); file = open('kept', 'w'); "
        "os.write(1, b'noise'); print('noise', flush=True); file.write(str(file.fileno() > 2))"
    )
    subprocess.run(
        ["/bin/sh", "-c", f'{sys.executable} -c "{code}" >&- 2>&-'], cwd=tmp_path, env=environment(), check=True
    )
    assert (tmp_path / "kept").read_text() == "True"


def test_signs_that_an_encoding_lacks_are_replaced(tmp_path: Path) -> None:
    words = ["leaderboard", "show", str(Path(__file__).parents[3] / "leaderboards/quick.json"), "--details"]
    ended = subprocess.run(
        [*COMMAND, *words],
        cwd=tmp_path,
        env={**environment(), "PYTHONIOENCODING": "ascii"},
        capture_output=True,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr
    assert "Hybrid HRL" in ended.stdout.decode("ascii")
