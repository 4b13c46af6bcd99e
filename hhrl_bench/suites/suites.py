"""Suites: benchmarks as data under ids, the units of work that they come to, and whose learning curves are published.

To add one, add a declaration to ``_DECLARED``: a :class:`ScoreSuite` of agents that need no training, a
:class:`TrainingSuite` of methods to train, or a :class:`TransferSuite` of methods to reuse in other tasks. From outside
the package call :func:`register_suite` in an extension. ``hhrl-bench run --suite ID`` and ``list suites`` then know it.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple, Protocol

from hhrl_agents import METHODS
from hhrl_bench.errors import SuiteError, UnknownSuiteError
from hhrl_bench.evaluation.store import Store
from hhrl_bench.execution.unit import Stages
from hhrl_bench.schema import RESERVED, STEM
from hhrl_bench.suites.units import Evaluation, Training, arm_trainings, seed_trainings
from hhrl_bench.tasks.tasks import get_task
from hhrl_bench.text import meant
from hhrl_bench.transfer.transfer import Transfer, sensible_arms


class Curves(NamedTuple):
    """Whose learning curves a leaderboard holds: those of the arms of transfers, and those of trainings."""

    transfers: Sequence[Transfer] = ()
    trainings: Sequence[Training] = ()


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

    def curves(self, folder: Path) -> Curves:
        """Return whose learning curves the leaderboard holds."""


@dataclass(frozen=True, slots=True)
class ScoreSuite:
    """Every agent plays the first ``episodes`` test episodes of every task."""

    id: str
    agents: tuple[str, ...]
    tasks: tuple[str, ...]
    episodes: int

    def stages(self, folder: Path) -> Stages:
        """Return every agent on every task of the suite."""
        return [
            [Evaluation(agent, get_task(task), self.episodes, folder) for task in self.tasks for agent in self.agents]
        ]

    def curves(self, folder: Path) -> Curves:
        """Return none."""
        return Curves()


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
        """Return the trainings of the sources, seed by seed, then those of all arms, target by target."""
        task, store = get_task(self.source), Store(folder)
        sources = [
            Training(method, task, self.seeds, self.episodes, _source(folder, method), store) for method in self.agents
        ]
        arms = [
            arm
            for method, transfer in self._transfers(folder)
            for arm in arm_trainings(transfer, METHODS[method], self.episodes, store)
        ]
        return [seed_trainings(sources), [*sources, *seed_trainings(arms)], arms]

    def curves(self, folder: Path) -> Curves:
        """Return every method's transfer to every target in which something of it can be reused."""
        return Curves(transfers=[transfer for _, transfer in self._transfers(folder)])

    def _transfers(self, folder: Path) -> Iterator[tuple[str, Transfer]]:
        for target in map(get_task, self.targets):
            for method in self.agents:
                if sensible_arms(METHODS[method], target):
                    source, own = str(_source(folder, method)), folder / method / target.id
                    yield method, Transfer(source, target, self.seeds, self.env_steps, own)


@dataclass(frozen=True, slots=True)
class TrainingSuite:
    """Methods are trained from nothing, each on the tasks of its own and with their budgets.

    pairs: a method and a task each; untrained: agents that are scored on all the tasks beside them.
    """

    id: str
    pairs: tuple[tuple[str, str], ...]
    seeds: tuple[int, ...]
    episodes: int
    untrained: tuple[str, ...] = ()

    @property
    def agents(self) -> tuple[str, ...]:
        """The agents that need no training, then the methods."""
        return (*self.untrained, *dict.fromkeys(method for method, _ in self.pairs))

    @property
    def tasks(self) -> tuple[str, ...]:
        """The tasks."""
        return tuple(dict.fromkeys(task for _, task in self.pairs))

    def stages(self, folder: Path) -> Stages:
        """Return what needs no training, then the trainings, seed by seed, and what they have come to."""
        untrained = ScoreSuite(self.id, self.untrained, self.tasks, self.episodes)
        trainings = self._trainings(folder)
        return [*untrained.stages(folder), seed_trainings(trainings), trainings]

    def curves(self, folder: Path) -> Curves:
        """Return the trainings."""
        return Curves(trainings=self._trainings(folder))

    def _trainings(self, folder: Path) -> list[Training]:
        return [
            Training(method, get_task(task), self.seeds, self.episodes, folder / method / task, Store(folder))
            for method, task in self.pairs
        ]


def _source(folder: Path, method: str) -> Path:
    return folder / method / "source"


_SEEDS = tuple(range(10))
_STRONG = ("rule-plus", "rule-tuned", "rule-robust")
_RULES = ("rule-1", "rule-2", "rule-3", "rule-4", *_STRONG, "oracle")
_REUSED = ("ddqn", "hybrid-hrl", "hybrid-hrl-plus")
_PAPERS = ("ddqn", "hrl-0", "hrl-1", "hrl-2", "hrl-3", "hybrid-hrl")
_METHODS = ("ddqn", "ddqn-plus", "hybrid-hrl", "hybrid-hrl-plus", "pqn")
_TASKS = (
    "stop-line-v0",
    "stop-line-paper-v0",
    "stop-line-dense-v1",
    "stop-line-erratic-v1",
    "stop-line-wet-v1",
    "stop-line-noisy-v1",
)

_DECLARED: tuple[Suite, ...] = (
    ScoreSuite(
        "quick",
        agents=(*_RULES, "ddqn", "hybrid-hrl", "hybrid-hrl-plus"),
        tasks=("stop-line-v0", "stop-line-paper-v0"),
        episodes=1000,
    ),
    ScoreSuite(
        "robustness",
        agents=("rule-3", "rule-4", *_STRONG, "ddqn", "hybrid-hrl", "hybrid-hrl-plus"),
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
        targets=("stop-line-heldout-v0", "stop-line-wet-v1", "stop-line-noisy-v1", "stop-line-dense-v1"),
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
        untrained=_RULES,
    ),
)

_registered: dict[str, Suite] = {suite.id: suite for suite in _DECLARED}

SUITES: Mapping[str, Suite] = MappingProxyType(_registered)
"""Every registered suite by its id."""


def register_suite(suite: Suite) -> None:
    """Make a suite known under its id, as if it were declared here.

    Raises:
        SuiteError: if it is none, its id is no word of small letters, digits and hyphens, or another suite has it.
    """
    if not callable(getattr(suite, "stages", None)):
        raise SuiteError(f"cannot register {suite!r} as a suite; give a ScoreSuite, a TrainingSuite or a TransferSuite")
    if not re.fullmatch(STEM, suite.id) or suite.id in RESERVED:
        raise SuiteError(
            f"a suite cannot have the id {suite.id!r}; write small letters, digits and hyphens, 61 at most, "
            f"and none of {', '.join(RESERVED)}"
        )
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
        raise UnknownSuiteError(
            f"unknown suite {suite_id!r}{meant(suite_id, SUITES)}; known suites: {', '.join(SUITES)}; "
            "a suite of your own is a file that ends in .json"
        ) from None
