"""The command line ``hhrl-bench``: every command brings in what does its work when it is run, not before."""

import os

try:
    from hhrl_bench.cli.interrupts import leave_on_interrupt
    from hhrl_bench.cli.streams import mend_streams
except KeyboardInterrupt:  # Ctrl-C, before there is anything that heeds it
    os.write(2, b"hhrl-bench: interrupted; what was not finished was not written\n")
    os._exit(130)

__all__ = ["main"]


def main() -> None:
    """Run ``hhrl-bench`` with the arguments of the process; an interrupt is heeded while modules are imported too."""
    mend_streams()
    leave_on_interrupt(_run)


def _run() -> None:
    from hhrl_bench.cli.app import app

    app()
