"""The command line ``hhrl-bench``: every command brings in what does its work when it is run, not before."""

from hhrl_bench.cli.app import main

__all__ = ["main"]
