"""Kinds of suites: benchmarks as data, the units of work that they come to, and the curves that are published."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple, Protocol

from hhrl_agents import METHODS
from hhrl_bench.evaluation.store import Store
from hhrl_bench.execution.unit import Stages
from hhrl_bench.suites.units import Evaluation, Training, arm_trainings
from hhrl_bench.tasks.tasks import get_task
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
        """Return the trainings of the sources, then all arms, target by target."""
        task, store = get_task(self.source), Store(folder)
        sources = [
            Training(method, task, self.seeds, self.episodes, _source(folder, method), store) for method in self.agents
        ]
        arms = [
            arm
            for method, transfer in self._transfers(folder)
            for arm in arm_trainings(transfer, METHODS[method], self.episodes, store)
        ]
        return [sources, arms]

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
        """Return what needs no training, then the trainings."""
        untrained = ScoreSuite(self.id, self.untrained, self.tasks, self.episodes)
        return [*untrained.stages(folder), self._trainings(folder)]

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
