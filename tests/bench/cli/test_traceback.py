"""Where an error comes from is shown on request, by a word or a variable; else an error is one line."""

from pathlib import Path

import pytest

from hhrl_bench.evaluation.results import Update, silent
from hhrl_bench.execution.unit import Outcome, attempt
from hhrl_bench.tracebacks import TRACEBACK_VARIABLE
from support.command_line import invoke

BROKEN = "def make(scenario):\n    return 1 // 0  # here\n"


@pytest.fixture(autouse=True)
def not_asked_for(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv(TRACEBACK_VARIABLE, "0")
    monkeypatch.chdir(tmp_path)


def test_an_error_is_one_line_by_default() -> None:
    assert invoke("run", "--suite", "slow").stderr.count("\n") == 1


def test_the_option_and_the_variable_ask_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = [invoke("--traceback", "run", "--suite", "slow")]
    monkeypatch.setenv(TRACEBACK_VARIABLE, "1")
    asked.append(invoke("run", "--suite", "slow"))
    for said in asked:
        assert said.exit_code == 2
        assert said.stdout == ""
        assert "hhrl_bench.errors.UnknownSuiteError" in said.stderr
        assert said.stderr.splitlines()[-1].startswith("hhrl-bench: unknown suite 'slow'")


def test_a_users_agent_shows_its_own_lines() -> None:
    Path("broken.py").write_text(BROKEN)
    for words, shown in (((), False), (("--traceback",), True)):
        said = invoke(*words, "evaluate", "broken:make", "--episodes", "1")
        assert said.exit_code == 2
        assert ("return 1 // 0  # here" in said.stderr) == ("Traceback" in said.stderr) == shown


def test_a_failed_unit_shows_its_own(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv(TRACEBACK_VARIABLE, "1")
    assert attempt(Broken(), None).failure == "ZeroDivisionError: here"
    assert "raise ZeroDivisionError" in capsys.readouterr().err


class Broken:
    name = "broken"

    def check(self) -> None:
        pass

    def run(self, update: Update = silent) -> Outcome:
        raise ZeroDivisionError("here")
