"""The tutorial: its cells run in order and print what the page says; its commands run."""

import contextlib
import io
import re
import shlex
from pathlib import Path
from typing import Any

import pytest

from support.command_line import invoke

ROOT = Path(__file__).parents[3]
TUTORIAL = (ROOT / "docs" / "tutorial.md").read_text()
CELL = re.compile(r"^```python\n(.*?)^```$(?:\n\n```text\n(.*?)^```$)?", re.MULTILINE | re.DOTALL)
COMMAND = re.compile(r"^hhrl-bench .*$", re.MULTILINE)


def test_cells_print_what_the_page_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    notebook: dict[str, Any] = {"__name__": "notebook"}
    cells = CELL.findall(TUTORIAL)
    assert len(cells) > 10
    for code, said in cells:
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(code, "tutorial", "exec"), notebook)
        assert printed.getvalue() == said, code


def test_its_commands_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    agent = next(code for code, _ in CELL.findall(TUTORIAL) if "class Careful" in code).split("\n\n\nscenario =")[0]
    Path("my_agent.py").write_text(f"{agent}\n\n\nmake_agent = lambda scenario: Careful(scenario, 0.5, 4.0)\n")
    commands = COMMAND.findall(TUTORIAL)
    assert len(commands) == 4
    for command in commands:
        done = invoke(*shlex.split(command)[1:])
        assert done.exit_code == 0, done.output
    assert {path.name for path in tmp_path.iterdir()} >= {"episode.png", "careful.csv", "datasets"}


def test_the_commands_of_the_page_on_data_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("leaderboards").symlink_to(ROOT / "leaderboards")
    commands = COMMAND.findall((ROOT / "docs" / "data.md").read_text())
    assert len(commands) == 5
    for command in commands:
        done = invoke(*shlex.split(command, comments=True)[1:])
        assert done.exit_code == 0, done.output
