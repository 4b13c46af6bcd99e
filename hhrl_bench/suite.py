"""Suites: benchmarks as data, and the units of work that they come to."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Protocol

from hhrl_agents import METHODS
from hhrl_bench.errors import UnknownSuiteError
from hhrl_bench.running import Stages
from hhrl_bench.tasks import get_task
from hhrl_bench.transfer import Transfer, sensible_arms
from hhrl_bench.units import Evaluation, Training, TransferArm


class Suite(Protocol):
    """A benchmark as data; its files of trainings lie in a folder that it is given."""

    @property
    def id(self) -> str:
        """Its name."""

    @property
    def episodes(self) -> int:
        """Test episodes of every evaluation."""

    @property
    def agents(self) -> tuple[str, ...]:
        """The agents that are scored or trained."""

    @property
    def tasks(self) -> tuple[str, ...]:
        """The ids of all tasks that there are results on."""

    def stages(self, folder: Path) -> Stages:
        """Return the units of work."""

    def transfers(self, folder: Path) -> Sequence[Transfer]:
        """Return the transfers whose arms are among the units."""


@dataclass(frozen=True, slots=True)
class ScoreSuite:
    """Every agent plays the first ``episodes`` test episodes of every task."""

    id: str
    agents: tuple[str, ...]
    tasks: tuple[str, ...]
    episodes: int

    def stages(self, folder: Path) -> Stages:
        """Return every agent on every task of the suite."""
        return [[Evaluation(agent, get_task(task), self.episodes) for task in self.tasks for agent in self.agents]]

    def transfers(self, folder: Path) -> Sequence[Transfer]:
        """Return none."""
        return ()


@dataclass(frozen=True, slots=True)
class TransferSuite:
    """Every method is trained on the source task, then reused in every target task, in every arm that makes sense.

    env_steps: of every arm, a seed; the source has its task's budget.
    """

    id: str
    agents: tuple[str, ...]
    source: str
    targets: tuple[str, ...]
    seeds: tuple[int, ...]
    env_steps: int
    episodes: int

    @property
    def tasks(self) -> tuple[str, ...]:
        """The source and the targets."""
        return (self.source, *self.targets)

    def stages(self, folder: Path) -> Stages:
        """Return the trainings of the sources, then all arms, target by target."""
        task = get_task(self.source)
        sources = [Training(method, task, self.seeds, self.episodes, _source(folder, method)) for method in self.agents]
        arms = [
            TransferArm(transfer, method, arm.id, self.episodes)
            for method, transfer in self._transfers(folder)
            for arm in sensible_arms(METHODS[method], transfer.target)
        ]
        return [sources, arms]

    def transfers(self, folder: Path) -> Sequence[Transfer]:
        """Return every method's transfer to every target in which something of it can be reused."""
        return [transfer for _, transfer in self._transfers(folder)]

    def _transfers(self, folder: Path) -> Iterator[tuple[str, Transfer]]:
        for target in map(get_task, self.targets):
            for method in self.agents:
                if sensible_arms(METHODS[method], target):
                    source, own = str(_source(folder, method)), folder / method / target.id
                    yield method, Transfer(source, target, self.seeds, self.env_steps, own)


_REUSED, _SEEDS = ("ddqn", "hybrid-hrl", "hybrid-hrl-plus"), tuple(range(10))

SUITES: Mapping[str, Suite] = MappingProxyType(
    {
        suite.id: suite
        for suite in (
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
                episodes=1000,
            ),
            TransferSuite(
                "transfer-shifts",
                agents=_REUSED,
                source="stop-line-v0",
                targets=("stop-line-heldout-v0", "stop-line-wet-v0", "stop-line-noisy-v0", "stop-line-dense-v0"),
                seeds=_SEEDS,
                env_steps=50_000,
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


def _source(folder: Path, method: str) -> Path:
    return folder / method / "source"
