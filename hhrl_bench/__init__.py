"""The harness of hhrl-bench: tasks, evaluation, training, leaderboards and the command line."""

TYPE_CHECKING = False  # importing typing would take longer than all until the command line heeds Ctrl-C

if TYPE_CHECKING:
    from typing import Any

    from hhrl_bench.api.comparison import Comparison, compare
    from hhrl_bench.api.evaluate import evaluate
    from hhrl_bench.api.evaluation import Evaluation
    from hhrl_bench.evaluation.loading import load_agent
    from hhrl_bench.evaluation.metrics import Least, Metric, Sum, register_metric
    from hhrl_bench.suites.suites import register_suite

    __version__: str

__all__ = [
    "Comparison",
    "Evaluation",
    "Least",
    "Metric",
    "Sum",
    "__version__",
    "compare",
    "evaluate",
    "load_agent",
    "register_metric",
    "register_suite",
]

_METRICS = "hhrl_bench.evaluation.metrics"
_HOMES = {
    **dict.fromkeys(("Comparison", "compare"), "hhrl_bench.api.comparison"),
    "Evaluation": "hhrl_bench.api.evaluation",
    "evaluate": "hhrl_bench.api.evaluate",
    "load_agent": "hhrl_bench.evaluation.loading",
    "register_suite": "hhrl_bench.suites.suites",
    **dict.fromkeys(("Least", "Metric", "Sum", "register_metric"), _METRICS),
}


def __getattr__(name: str) -> "Any":
    if name == "__version__":
        return _version()
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module  # noqa: PLC0415

    return getattr(import_module(_HOMES[name]), name)


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version  # noqa: PLC0415

    try:
        return version("hhrl-bench")
    except PackageNotFoundError:
        return "0+unknown"
