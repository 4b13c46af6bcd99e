"""Suites: a benchmark as data, agents x tasks x episodes, and the generator of its units."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import NamedTuple

from hhrl_bench.errors import UnknownSuiteError
from hhrl_bench.tasks import Task, get_task


@dataclass(frozen=True, slots=True)
class Suite:
    """A named benchmark: every agent plays the first ``episodes`` test episodes of every task."""

    id: str
    agents: tuple[str, ...]
    tasks: tuple[str, ...]
    episodes: int


class Unit(NamedTuple):
    """The smallest piece of a suite's work: one agent on one task, with all its training seeds."""

    agent: str
    task: Task
    episodes: int


SUITES: Mapping[str, Suite] = MappingProxyType(
    {
        suite.id: suite
        for suite in (
            Suite(
                "quick",
                agents=("rule-1", "rule-2", "rule-3", "rule-4", "rule-plus", "ddqn", "hybrid-hrl", "hybrid-hrl-plus"),
                tasks=("stop-line-v0",),
                episodes=1000,
            ),
            Suite(
                "robustness",
                agents=("rule-3", "rule-4", "rule-plus", "ddqn", "hybrid-hrl", "hybrid-hrl-plus"),
                tasks=("stop-line-v0", "stop-line-heldout-v0", "adversary-v0"),
                episodes=1000,
            ),
        )
    }
)


def get_suite(suite_id: str) -> Suite:
    """Return the suite of an id.

    Raises:
        UnknownSuiteError: naming the known ids.
    """
    try:
        return SUITES[suite_id]
    except KeyError:
        raise UnknownSuiteError(f"unknown suite {suite_id!r}; known suites: {', '.join(SUITES)}") from None


def units(suite: Suite) -> Iterator[Unit]:
    """Return, one after the other, every agent on every task of the suite."""
    for task in suite.tasks:
        for agent in suite.agents:
            yield Unit(agent, get_task(task), suite.episodes)
