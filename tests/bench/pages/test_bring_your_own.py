"""The page on agents, scenarios and suites of one's own works from top to bottom, in one folder."""

import re
import shlex
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path

import pytest

from support.command_line import invoke
from support.own_scenarios import forgotten_scenarios

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "bring-your-own.md").read_text()
STEPS = "20_000"
"""Steps of the trainings on the page, of which the test takes fewer."""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """An empty current folder; what is registered and imported there is forgotten again."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["hhrl-bench"])
    with forgotten_scenarios():
        yield tmp_path


def blocks() -> list[tuple[str, str, str]]:
    """Return the blocks of the page in their order: the language, the last file named before it, and the text."""
    found = re.finditer(r"^```(\w+)\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    return [(one[1], (re.findall(r"`([\w-]+\.json)`", PAGE[: one.start()]) or [""])[-1], one[2]) for one in found]


def run_python(code: str) -> None:
    """Write a block that begins with the name of a file into that file; run any other, and one when it is called."""
    if named := re.match(r"# (\w+\.py)\n", code):
        Path(named[1]).write_text(code)
    else:
        exec(compile(code, "bring-your-own.md", "exec"), {"__name__": "documentation"})


def run_command(line: str) -> None:
    command, _, target = line.partition(" > ")
    words = shlex.split(command, comments=True)
    if words[0] == "python":
        code = Path(words[1]).read_text()
        assert STEPS in code
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Stable-Baselines3 says that it makes the folder
            exec(compile(code.replace(STEPS, "1_000"), words[1], "exec"), {"__name__": "__main__"})
        return
    assert words[0] == "hhrl-bench"
    result = invoke(*words[1:])
    assert result.exit_code == 0, f"{line}: {result.output}"
    assert result.stdout.strip() or "wrote" in result.stderr
    if target:
        Path(target).write_text(result.stdout)


@pytest.mark.usefixtures("folder")
def test_every_block_runs() -> None:
    pytest.importorskip("stable_baselines3")
    pytest.importorskip("PIL")
    languages = set()
    for language, file, text in blocks():
        languages.add(language)
        if language == "python":
            run_python(text)
        elif language == "json":
            Path(file).write_text(text)
        else:
            for line in text.splitlines():
                run_command(line)
    assert languages == {"python", "json", "sh"}
    assert Path("school.png").exists()


def test_own_code_is_at_most_ten_lines() -> None:
    for file in ("gentle.py", "train_sb3.py", "noisy.py", "mine.py"):
        code = next(text for _, _, text in blocks() if text.startswith(f"# {file}"))
        lines = [line for line in code.splitlines() if line.strip() and not line.startswith("#")]
        assert len(lines) <= 10, file
