"""What episodes came to: the records that every metric is computed from, and the totals that become them."""

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from hhrl_bench.evaluation.metrics import METRICS, Metric, metric_error
from hhrl_bench.evaluation.rollout import Rollout, Step
from hhrl_envs import Outcome
from hhrl_envs.arrays import Codes, Flags, Keys

Arrays = Mapping[str, NDArray[Any]]


@dataclass(frozen=True, slots=True, eq=False)
class EpisodeRecords:
    """What N episodes came to; every array is [N, ...], episode i being the same world for every agent.

    Attributes:
        seed: world seed, uint64.
        outcome: how the episode ended (:class:`hhrl_envs.Outcome`), int8.
        steps: environment steps, int32.
        measured: the metrics that came up over the steps, by their keys, in the order of ``METRICS``; each is an
            attribute too.
    """

    seed: Keys
    outcome: Codes
    steps: NDArray[np.int32]
    measured: Arrays

    def __len__(self) -> int:
        return len(self.seed)

    def __getattr__(self, key: str) -> NDArray[Any]:
        if key in METRICS and key in self.measured:
            return self.measured[key]
        raise AttributeError(f"the records have no {key!r}; they have {', '.join(self.arrays())}")

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return all arrays by their names."""
        return {"seed": self.seed, "outcome": self.outcome, "steps": self.steps, **self.measured}

    def digest(self) -> str:
        """Return the sha256, in hex, of every array's name and little-endian bytes: equal for equal episodes."""
        sha = hashlib.sha256()
        for name, array in self.arrays().items():
            sha.update(f"{name}:{array.dtype.name}:{len(self)};".encode())
            sha.update(array.astype(array.dtype.newbyteorder("<")).tobytes())
        return sha.hexdigest()

    def with_arrays(self, arrays: Arrays) -> Self:
        """Return records of the same kind with these arrays, named as those of ``arrays()``."""
        own = {name: array for name, array in arrays.items() if name not in self.measured}
        return type(self)(**own, measured={name: arrays[name] for name in self.measured})

    def part(self, rows: slice) -> Self:
        """Return the records of some of the episodes."""
        return self.with_arrays({name: array[rows] for name, array in self.arrays().items()})

    def only(self, metrics: Iterable[str]) -> Self:
        """Return the same records without the measured metrics of other keys than these."""
        kept, arrays = set(metrics), self.arrays()
        own = {name: array for name, array in arrays.items() if name not in self.measured}
        return type(self)(**own, measured={name: array for name, array in self.measured.items() if name in kept})


@dataclass(frozen=True, slots=True, eq=False)
class TrafficRecords(EpisodeRecords):
    """The same in a world with learned front vehicles, where ``outcome`` is that of all vehicles the agent drives.

    It is SUCCESS if all have succeeded, else the worst: a collision, then a crossed line, then the time limit. The
    measured metrics are those of the first of them; ``steps`` are those until the last vehicle's episode ended.

    Attributes:
        feasible: whether some ego could have succeeded, bool.
        outcomes: how the episode of every agent ended, the ego first, int8 [N, A].
    """

    feasible: Flags
    outcomes: Codes

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return all arrays by their names."""
        return {**EpisodeRecords.arrays(self), "feasible": self.feasible, "outcomes": self.outcomes}


def join(parts: Sequence[EpisodeRecords], length: int) -> EpisodeRecords:
    """Return the first ``length`` episodes of several records of one kind, one after the other."""
    arrays = [part.arrays() for part in parts]
    return parts[0].with_arrays({name: np.concatenate([one[name] for one in arrays])[:length] for name in arrays[0]})


class Totals:
    """The totals of metrics over the steps of a rollout; by default of all registered ones."""

    def __init__(self, rollout: Rollout, metrics: Iterable[Metric] | None = None) -> None:
        chosen = METRICS.values() if metrics is None else metrics
        known = {one.key: one.accumulation for one in chosen if one.accumulation is not None}
        started = {key: accumulation.start(rollout) for key, accumulation in known.items()}
        self._rollout, self._totals = rollout, {key: one for key, one in started.items() if one is not None}
        self._accumulations = {key: known[key] for key in self._totals}

    def add(self, step: Step) -> None:
        """Add a step of the rollout."""
        first, key = step.first, ""
        try:
            for key, accumulation in self._accumulations.items():
                accumulation.add(self._totals[key], first)
        except Exception as error:
            raise metric_error(key, error) from error

    def records(self) -> EpisodeRecords:
        """Return the records of the rollout's episodes, which are over."""
        seeds, simulator = self._rollout.seeds, self._rollout.simulator
        own = simulator.agent_outcomes.reshape(len(seeds), -1)[:, list(self._rollout.slots)]
        ended = (seeds.copy(), worst_outcome(own), simulator.steps.astype(np.int32), self._totals)
        if not simulator.scenario.learned_fronts:
            return EpisodeRecords(*ended)
        return TrafficRecords(*ended, feasible=simulator.feasible, outcomes=simulator.agent_outcomes)


_BY_WEIGHT = np.array([Outcome.COLLISION, Outcome.NOT_STOP, Outcome.REAR_ENDED, Outcome.TIMEOUT, Outcome.FOILED])


def worst_outcome(outcomes: Codes) -> Codes:
    """Return the outcome that counts for vehicles with these, int8 [N], [N, slots]: SUCCESS if all have succeeded."""
    found = (outcomes[:, None, :] == _BY_WEIGHT[:, None]).any(axis=2)
    worst = np.where(found.any(axis=1), _BY_WEIGHT[found.argmax(axis=1)], Outcome.SUCCESS)
    return worst.astype(np.int8)
