"""Errors that name a bad input in one line."""


class InputError(ValueError):
    """A bad input; the message is one line that says what is wrong and what to write instead."""


class UnknownScenarioError(InputError, KeyError):
    """A scenario id that is not registered; a ``KeyError`` too, for ``SCENARIOS`` is a mapping."""

    __str__ = Exception.__str__  # a KeyError would show its message as a repr


def require_value(holds: bool, name: str, value: object, allowed: str) -> None:
    """Return nothing where ``holds``; else raise an ``InputError`` that names the value and what to write instead."""
    if not holds:
        raise InputError(f"{name} is {value}; write {allowed}")
