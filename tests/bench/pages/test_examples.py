"""The examples run, and what docs/extending.md shows works."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "extending.md").read_text()
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))


def run(*arguments: str) -> str:
    """Return what a Python process, started in the checkout, prints; it must succeed."""
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    done = subprocess.run(
        [sys.executable, *arguments], capture_output=True, text=True, cwd=ROOT, env=environment, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs_and_says_something(example: Path) -> None:
    if example.stem == "learned_method":
        pytest.importorskip("torch")
    assert run(str(example)).strip()


@pytest.mark.parametrize("command", "".join(blocks("sh")).splitlines())
def test_commands_with_extensions_run(command: str) -> None:
    assert command.startswith("hhrl-bench --extension ")
    assert run("-m", "hhrl_bench", *shlex.split(command)[1:]).strip()


@pytest.mark.parametrize("code", blocks("python"))
def test_python_blocks_run(code: str) -> None:
    run("-c", code)


def test_what_is_registered_outside_is_seen_everywhere() -> None:
    extensions = [
        word for name in ("metric", "scenario", "rule_agent") for word in ("--extension", f"examples/{name}.py")
    ]
    evaluate = ("evaluate", "rule-patient", "--task", "stop-line-greasy-v0", "--episodes", "20")
    assert '"hard_braking":' in run("-m", "hhrl_bench", *extensions, *evaluate, "--json")
    assert '"hard_braking":' in run("-m", "hhrl_bench", *extensions, "leaderboard", "schema")
    assert "stop-line-greasy-v0" in run("-m", "hhrl_bench", *extensions, "list", "tasks")
    assert "stop-line-greasy-v0" not in run("-m", "hhrl_bench", "list", "tasks")
    assert "hard_braking" not in run("-m", "hhrl_bench", "leaderboard", "schema")


def test_the_page_names_every_example() -> None:
    assert {path.name for path in EXAMPLES} == set(re.findall(r"\(\.\./examples/(\w+\.py)\)", PAGE))
