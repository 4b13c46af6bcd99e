"""The harness of hhrl-bench: tasks, evaluation, training, leaderboards and the command line."""

from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hhrl_bench.evaluation.evaluate import evaluate
    from hhrl_bench.evaluation.loading import load_agent

__all__ = ["__version__", "evaluate", "load_agent"]

try:
    __version__ = version("hhrl-bench")
except PackageNotFoundError:
    __version__ = "0+unknown"


_HOMES = {"evaluate": "hhrl_bench.evaluation.evaluate", "load_agent": "hhrl_bench.evaluation.loading"}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module  # noqa: PLC0415

    return getattr(import_module(_HOMES[name]), name)
