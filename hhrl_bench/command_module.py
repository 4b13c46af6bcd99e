"""Brings in what does the work of a command only when it is run: numba, scipy and torch, which ``--help`` need not."""

from importlib import import_module
from types import ModuleType


def command_module(name: str) -> ModuleType:
    """Return the module ``hhrl_bench.NAME``; from now on it is said when the simulator is being compiled."""
    from hhrl_bench.compiling import announce_compiling  # noqa: PLC0415

    announce_compiling()
    return import_module(f"hhrl_bench.{name}")
