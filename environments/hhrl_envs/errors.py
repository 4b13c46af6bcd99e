"""Errors that name a bad input in one line."""

from importlib.util import find_spec

_LONGEST = 1000


class InputError(ValueError):
    """A bad input; the message is one line that says what is wrong and what to write instead."""

    def __init__(self, message: object) -> None:
        """Keep to one line whatever the message quotes; libraries raise an error again as ``type(error)(error)``."""
        super().__init__(one_line(str(message)))


def one_line(text: str) -> str:
    """Return a text as one line of at most 1,000 printable characters: control characters are spelt out."""
    line = " ".join(map(str.strip, text.splitlines()))
    line = "".join(char if char.isprintable() else ascii(char)[1:-1] for char in line)
    return line if len(line) <= _LONGEST else line[: _LONGEST - 3] + "..."


class UnknownScenarioError(InputError, KeyError):
    """A scenario id that is not registered; a ``KeyError`` too, for ``SCENARIOS`` is a mapping."""

    __str__ = Exception.__str__  # a KeyError would show its message as a repr


def require_value(holds: bool, name: str, value: object, allowed: str) -> None:
    """Raise an ``InputError`` unless ``holds``; it names the value and what to write instead."""
    if not holds:
        raise InputError(f"{name} is {value}; write {allowed}")


class MissingExtraError(InputError):
    """A feature was asked for whose optional dependency is not installed."""


def require(module: str, extra: str) -> None:
    """Raise a ``MissingExtraError`` unless the top-level ``module`` is installed; it names the extra that brings it."""
    if find_spec(module) is None:
        brings = f"the extra '{extra}' of hhrl-bench brings it; in a checkout: pip install -e '.[{extra}]'"
        raise MissingExtraError(f"{module} is not installed; {brings}")
