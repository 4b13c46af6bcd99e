"""The console that tables are printed on, and the line that says why nothing is to be seen for some seconds."""

import os
from functools import cache
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from rich.console import Console

PLAIN_WIDTH = 160


def console() -> "Console":
    """Return the console of stdout; wide enough for any table where that is no terminal and COLUMNS is not set."""
    from rich.console import Console

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
