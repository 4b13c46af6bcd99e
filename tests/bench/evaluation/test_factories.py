"""Users' factories, called in this process: what is wrong with one is said in one line, and where."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from hhrl_bench.errors import AgentError
from hhrl_bench.evaluation.factories import call_factory, require_module
from hhrl_envs import get_scenario
from support.own_agents import COASTING

SCENARIO = get_scenario("stop-line-v0")

FACTORIES = (
    COASTING
    + """
def crashing(scenario):
    raise RuntimeError("out of paint")

def careless(scenario):
    import dataclasses
    return dataclasses.replace(scenario, horizon=-1)

def greedy(scenario, speed):
    return None

class Headless(Coasting):
    def __init__(self):
        pass

def nothing(scenario):
    return None

value = 3
"""
)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder with modules of factories, which the process forgets again."""
    monkeypatch.setattr(sys, "path", [*sys.path])
    before = set(sys.modules)
    (tmp_path / "my_factories.py").write_text(FACTORIES)
    (tmp_path / "needs_more.py").write_text("import no_such_module_anywhere")
    (tmp_path / "misspelt.py").write_text("x = (")
    yield tmp_path
    for name in {"my_factories", "needs_more", "misspelt"} - before:
        sys.modules.pop(name, None)


@pytest.mark.parametrize(
    ("source", "said"),
    [
        (
            "my_factories:crashing",
            "my_factories:crashing, called with the scenario, raised RuntimeError: out of paint (my_factories.py, l",
        ),
        (
            "my_factories:careless",
            "Scenario.horizon is -1; write an integer from 1 to 20000 (steps) (my_factories.py, line 19)",
        ),
        (
            "my_factories:greedy",
            "greedy (my_factories.py, line 21) cannot be called with the scenario: missing a required argument",
        ),
        (
            "my_factories:Headless",
            "Headless (my_factories.py, line 24) cannot be called with the scenario: too many positional arguments",
        ),
        ("my_factories:nothing", "my_factories:nothing returned NoneType; return an agent"),
        ("my_factories:value", "module 'my_factories' has no callable 'value'; write module:factory"),
        ("my_factories:missing", "module 'my_factories' has no callable 'missing'"),
        ("my_factories:", "module 'my_factories' has no callable ''"),
        (
            "needs_more:make",
            "cannot import 'needs_more': ModuleNotFoundError: No module named 'no_such_module_anywhere'",
        ),
        ("misspelt:make", "cannot import 'misspelt': SyntaxError"),
        ("nowhere:make", "cannot import 'nowhere': ModuleNotFoundError"),
        (":make", "cannot import ''"),
        ("..up:make", "cannot import '..up'"),
    ],
)
def test_a_factory_that_fails_is_blamed_in_its_own_file(folder: Path, source: str, said: str) -> None:
    with pytest.raises(AgentError) as caught:
        call_factory(source, SCENARIO, folder)
    message = str(caught.value)
    assert said in message
    assert len(message.splitlines()) == 1


@pytest.mark.parametrize("source", ["nowhere:make", ":make", "..up:make", "a\0b:make", "__main__.x y:make"])
def test_a_module_that_is_not_there_is_missed_before_anything_is_run(source: str) -> None:
    with pytest.raises(AgentError, match="cannot import"):
        require_module(source)


def test_a_module_that_is_there_is_found_without_running_it(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    require_module("needs_more:make")
    require_module("misspelt:make")
    assert "needs_more" not in sys.modules


def test_a_file_is_not_a_module() -> None:
    with pytest.raises(AgentError, match=r"'mine\.py:make' names a file; write the module, as in mine:make"):
        require_module("mine.py:make")
