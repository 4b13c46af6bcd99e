"""Per-episode records of an evaluation: the numbers every metric is computed from."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from hhrl_bench.evaluation.records import RunTrafficRecord, TrafficRecord, metric_record
from hhrl_bench.schema import OutcomeName
from hhrl_bench.statistics.intervals import Estimate, bootstrap_mean, generator, wilson
from hhrl_envs import Outcome


@dataclass(frozen=True, slots=True, eq=False)
class EpisodeRecords:
    """What N episodes came to; every field is an array [N], episode i being the same world for every agent.

    Attributes:
        seed: world seed, uint64.
        outcome: how the episode ended (:class:`hhrl_envs.Outcome`), int8.
        steps: environment steps, int32.
        return_task: undiscounted sum of r^task, float64.
        return_option: undiscounted sum of r^option for the selected options; NaN for flat agents, float64.
        return_action: undiscounted sum of r^action for the selected options; NaN for flat agents, float64.
        unsmooth: steps with too large a jerk, int32.
        unsafe: sum of the unsafe penalties of both sub-goals, positive, float64.
        impact_speed: speed over the front vehicle's at a collision, m/s; NaN without one, float64.
        smallest_gap: smallest free road to a front vehicle, m; NaN if there never was one in range, float64.
        smallest_ttc: smallest free road over closing speed (time to collision), s, at most 10; NaN if never closing.
    """

    seed: NDArray[np.uint64]
    outcome: NDArray[np.int8]
    steps: NDArray[np.int32]
    return_task: NDArray[np.float64]
    return_option: NDArray[np.float64]
    return_action: NDArray[np.float64]
    unsmooth: NDArray[np.int32]
    unsafe: NDArray[np.float64]
    impact_speed: NDArray[np.float64]
    smallest_gap: NDArray[np.float64]
    smallest_ttc: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.seed)

    def digest(self) -> str:
        """Return the sha256, in hex, of every field's name and little-endian bytes: equal for equal episodes."""
        sha = hashlib.sha256()
        for field in fields(self):
            array = getattr(self, field.name)
            sha.update(f"{field.name}:{array.dtype.name}:{len(self)};".encode())
            sha.update(array.astype(array.dtype.newbyteorder("<")).tobytes())
        return sha.hexdigest()


@dataclass(frozen=True, slots=True, eq=False)
class TrafficRecords(EpisodeRecords):
    """The same in a world with learned front vehicles, where ``outcome`` is that of all vehicles the agent drives.

    It is SUCCESS if all have succeeded, else the worst: a collision, then a crossed line, then the time limit. The
    returns and counts are those of the first of them; ``steps`` are those until the last vehicle's episode ended.

    Attributes:
        feasible: whether some ego could have succeeded, bool.
        outcomes: how the episode of every agent ended, the ego first, int8 [N, A].
    """

    feasible: NDArray[np.bool_]
    outcomes: NDArray[np.int8]


def join(parts: Sequence[EpisodeRecords], length: int) -> EpisodeRecords:
    """Return the first ``length`` episodes of several records of one kind, one after the other."""
    kind = type(parts[0])
    names = [field.name for field in fields(kind)]
    return kind(**{name: np.concatenate([getattr(part, name) for part in parts])[:length] for name in names})


OUTCOMES: Mapping[OutcomeName, Outcome] = {name: Outcome[name.upper()] for name in get_args(OutcomeName)}


def counts(records: EpisodeRecords) -> RunTrafficRecord | None:
    """Return the counts over the episodes of one run; None where the ego is the only agent of the world."""
    if not isinstance(records, TrafficRecords):
        return None
    return RunTrafficRecord(
        feasible=int(records.feasible.sum()),
        success_feasible=_successes(records),
        vehicles=tuple(
            {name: int((own == outcome).sum()) for name, outcome in OUTCOMES.items() if (own == outcome).any()}
            for own in records.outcomes.T
        ),
    )


def summarise(played: Sequence[EpisodeRecords]) -> TrafficRecord | None:
    """Return the shares with their intervals, over runs if there are several, else over episodes; None as above."""
    runs = [records for records in played if isinstance(records, TrafficRecords)]
    if not runs:
        return None
    feasible = [int(records.feasible.sum()) for records in runs]
    lengths, successes = [len(records) for records in runs], [_successes(records) for records in runs]
    return TrafficRecord(
        feasible=metric_record(_share(feasible, lengths, "feasible")),
        success_feasible=metric_record(_share(successes, feasible, "success_feasible")),
    )


def _successes(records: TrafficRecords) -> int:
    return int(((records.outcome == Outcome.SUCCESS) & records.feasible).sum())


def _share(hits: Sequence[int], of: Sequence[int], key: str) -> Estimate:
    """Return the share of hits; not a number where there is nothing to count."""
    if len(of) == 1 and of[0] > 0:
        return wilson(hits[0], of[0])
    shares = np.array([hit / total if total else np.nan for hit, total in zip(hits, of, strict=True)])
    return bootstrap_mean(shares, generator(key), "bootstrap-seeds")
