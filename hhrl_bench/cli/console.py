"""The console that tables are printed on, progress on stderr, and the line that says why nothing happens at first."""

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from rich.console import Console

    from hhrl_bench.evaluation.results import Update

LINE_INTERVAL = 10.0
"""Seconds between two plain lines of progress that have nothing else to say."""


def console() -> "Console":
    """Return the console of stdout; wide enough for any table where that is no terminal and COLUMNS is not set."""
    from rich.console import Console

    from hhrl_bench.text import PLAIN_WIDTH

    console = Console(markup=False, emoji=False)  # names are text, whatever brackets and colons they hold
    if not console.is_terminal and "COLUMNS" not in os.environ:
        console.width = PLAIN_WIDTH
    return console


@cache
def announce_compiling() -> None:
    """Say on stderr when the simulator is first compiled from now on; every command that simulates calls this.

    Kernels that come from the cache are not compiled.
    """
    from numba.core import event

    class Compiling(event.Listener):
        said = False

        def on_start(self, _: Any) -> None:
            if not self.said:
                self.said = True
                typer.echo("hhrl-bench: compiling the simulator, a few seconds, once", err=True)

        def on_end(self, _: Any) -> None:
            pass

    event.register("numba:compile", Compiling())  # type: ignore[no-untyped-call]


@contextmanager
def progress(title: str) -> Iterator["Update"]:
    """Return a context whose value shows progress when it is called: a bar on a terminal, plain lines elsewhere.

    There, what has no note is said at most every LINE_INTERVAL seconds.
    """
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    if not console.is_terminal:
        yield _Lines(console, title)
        return
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[note]}"), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(title, total=None, note="")
        yield lambda done, total, note: bar.update(task, completed=done, total=total, note=note)


class _Lines:
    """Shows progress as plain lines."""

    def __init__(self, console: "Console", title: str) -> None:
        self._console, self._title = console, title
        self._due = time.monotonic() + LINE_INTERVAL

    def __call__(self, done: int, total: int, note: str) -> None:
        """Say how much is done, unless that can wait."""
        if note or time.monotonic() >= self._due:
            self._due = time.monotonic() + LINE_INTERVAL
            line = f"{self._title}: {done:,} of {total:,} {note}".rstrip()
            self._console.print(line, markup=False, highlight=False, soft_wrap=True)
