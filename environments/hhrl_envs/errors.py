"""Errors that name a bad input in one line."""


class InputError(ValueError):
    """A bad input; the message is one line that says what is wrong and what to write instead."""


class UnknownScenarioError(InputError):
    """A scenario id that is not registered."""
