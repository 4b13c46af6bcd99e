"""An option that takes one value is given once, in every command that there is; those of several values, again."""

from collections.abc import Iterator
from typing import Any

import pytest
from typer.main import get_command

from hhrl_bench.cli.app import app
from hhrl_bench.cli.once import GivenOnce
from support.command_line import invoke


def commands(command: Any, words: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    yield words, command
    for name, one in getattr(command, "commands", {}).items():
        yield from commands(one, (*words, name))


COMMANDS = dict(commands(get_command(app)))
OPTIONS = [
    pytest.param(words, option, id=" ".join((*words, option.opts[0])))
    for words, command in COMMANDS.items()
    for option in command.params
    if option.param_type_name == "option" and not option.is_flag
]


@pytest.mark.parametrize("command", [pytest.param(one, id=" ".join(words)) for words, one in COMMANDS.items() if words])
def test_every_command_refuses(command: Any) -> None:
    assert isinstance(command, GivenOnce) or command.commands


@pytest.mark.parametrize(("words", "option"), OPTIONS)
def test_an_option_of_one_value_is_refused_in_one_line_if_it_is_given_twice(
    words: tuple[str, ...], option: Any
) -> None:
    name = option.opts[0]
    result = invoke(*words, name, "a", f"{name}=b", "--help")
    if option.multiple:
        assert (result.exit_code, "Usage" in result.stdout) == (0, True)
        return
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr == f"hhrl-bench: Option '{name}' is given 2 times; give it once.\n"


def test_a_flag_says_the_same_twice() -> None:
    assert invoke("list", "suites", "--json", "--json").exit_code == 0
