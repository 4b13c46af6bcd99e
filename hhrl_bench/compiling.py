"""Says that the simulator is being compiled, which takes seconds in which nothing else is to be seen."""

from functools import cache
from typing import Any

import typer
from numba.core import event


class _Compiling(event.Listener):
    """Says so at the first compilation of the process; kernels that come from the cache are none."""

    said = False

    def on_start(self, _: Any) -> None:
        if not self.said:
            self.said = True
            typer.echo("hhrl-bench: compiling the simulator, a few seconds, once", err=True)

    def on_end(self, _: Any) -> None:
        pass


@cache
def announce_compiling() -> None:
    """Return nothing; from now on the first compilation is said on stderr, whoever asks for it."""
    event.register("numba:compile", _Compiling())  # type: ignore[no-untyped-call]
