"""The command line as ``python -m hhrl_bench``."""

from hhrl_bench.cli import main

main()
