"""Tracebacks on request: what is said in one line, and where it comes from, for those who look into their own code."""

import os
import traceback

TRACEBACK_VARIABLE = "HHRL_TRACEBACK"
"""The environment variable that asks for tracebacks, unless it is empty or 0; processes of a command inherit it."""


def show_traceback(error: BaseException) -> None:
    """Print on stderr where an error comes from, with those that led to it, if that is asked for."""
    if os.environ.get(TRACEBACK_VARIABLE, "") not in {"", "0"}:
        traceback.print_exception(error)
