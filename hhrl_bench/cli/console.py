"""The console that tables are printed on, progress on stderr, and the line that says why nothing happens at first."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from rich.console import Console

    from hhrl_bench.evaluation.results import Update


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
    """Return a context whose value shows progress when it is called: a bar on a terminal, plain lines elsewhere."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda done, total, note: console.print(
            f"{title}: {done:,} of {total:,} {note}".rstrip(), markup=False, highlight=False, soft_wrap=True
        )
        return
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[note]}"), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(title, total=None, note="")
        yield lambda done, total, note: bar.update(task, completed=done, total=total, note=note)
