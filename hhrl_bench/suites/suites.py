"""Suites by id.

To add one, add a declaration to ``_DECLARED``: a :class:`~hhrl_bench.suites.kinds.ScoreSuite` of agents that need no
training, a :class:`~hhrl_bench.suites.kinds.TrainingSuite` of methods to train, or a
:class:`~hhrl_bench.suites.kinds.TransferSuite` of methods to reuse in other tasks. From outside the package call
:func:`register_suite`. ``hhrl-bench run --suite ID``, ``list suites`` and the leaderboards know it then.
"""

from collections.abc import Mapping
from types import MappingProxyType

from hhrl_bench.errors import SuiteError, UnknownSuiteError
from hhrl_bench.suites.kinds import ScoreSuite, Suite, TrainingSuite, TransferSuite

_SEEDS = tuple(range(10))
_REUSED = ("ddqn", "hybrid-hrl", "hybrid-hrl-plus")
_PAPERS = ("ddqn", "hrl-0", "hrl-1", "hrl-2", "hrl-3", "hybrid-hrl")
_METHODS = ("ddqn", "ddqn-plus", "hybrid-hrl", "hybrid-hrl-plus", "pqn")
_TASKS = (
    "stop-line-v0",
    "stop-line-paper-v0",
    "stop-line-dense-v0",
    "stop-line-erratic-v0",
    "stop-line-wet-v0",
    "stop-line-noisy-v0",
)

_DECLARED: tuple[Suite, ...] = (
    ScoreSuite(
        "quick",
        agents=("rule-1", "rule-2", "rule-3", "rule-4", "rule-plus", "ddqn", "hybrid-hrl", "hybrid-hrl-plus"),
        tasks=("stop-line-v0",),
        episodes=1000,
    ),
    ScoreSuite(
        "robustness",
        agents=("rule-3", "rule-4", "rule-plus", "ddqn", "hybrid-hrl", "hybrid-hrl-plus"),
        tasks=("stop-line-v0", "stop-line-heldout-v0", "adversary-v0"),
        episodes=1000,
    ),
    TransferSuite(
        "transfer",
        agents=_REUSED,
        source="stop-line-v0",
        targets=(
            "red-light-v0",
            "stop-and-go-v0",
            "two-stops-v0",
            "follow-v0",
            "solo-stop-v0",
            "option-only-v0",
        ),
        seeds=_SEEDS,
        env_steps=50_000,
        episodes=250,
    ),
    TransferSuite(
        "transfer-shifts",
        agents=_REUSED,
        source="stop-line-v0",
        targets=("stop-line-heldout-v0", "stop-line-wet-v0", "stop-line-noisy-v0", "stop-line-dense-v0"),
        seeds=_SEEDS,
        env_steps=50_000,
        episodes=250,
    ),
    TrainingSuite(
        "trainings",
        pairs=(
            ("follow-only", "red-light-v0"),  # success in follow-v0 is not visible in a state
            ("option-only", "option-only-v0"),
            ("hybrid-hrl", "stop-line-v0"),
        ),
        seeds=_SEEDS,
        episodes=1000,
    ),
    TrainingSuite(
        "paper",
        pairs=tuple((method, "stop-line-paper-v0") for method in _PAPERS),
        seeds=_SEEDS,
        episodes=1000,
        untrained=("rule-1", "rule-2", "rule-3", "rule-4"),
    ),
    TrainingSuite(
        "full",
        pairs=tuple((method, task) for task in _TASKS for method in _METHODS),
        seeds=_SEEDS,
        episodes=250,
        untrained=("rule-1", "rule-2", "rule-3", "rule-4", "rule-plus"),
    ),
)

_registered: dict[str, Suite] = {suite.id: suite for suite in _DECLARED}

SUITES: Mapping[str, Suite] = MappingProxyType(_registered)
"""Every registered suite by its id."""


def register_suite(suite: Suite) -> None:
    """Make a suite known under its id, as if it were declared here.

    Raises:
        SuiteError: if another suite has that id.
    """
    if _registered.setdefault(suite.id, suite) != suite:
        raise SuiteError(f"there is a suite {suite.id!r} already; write another id, such as 'my-suite'")


def get_suite(suite_id: str) -> Suite:
    """Return the suite of an id.

    Raises:
        UnknownSuiteError: naming the known ids.
    """
    try:
        return SUITES[suite_id]
    except KeyError:
        raise UnknownSuiteError(f"unknown suite {suite_id!r}; known suites: {', '.join(SUITES)}") from None
