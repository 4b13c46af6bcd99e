"""The command line as a script that says on stderr when it heeds interrupts, before it imports what does the work."""

import sys

from hhrl_bench import cli

HEEDING = "heeding"

if __name__ == "__main__":
    run = cli._run

    def announced() -> None:
        print(HEEDING, file=sys.stderr, flush=True)
        run()

    cli._run = announced
    cli.main()
