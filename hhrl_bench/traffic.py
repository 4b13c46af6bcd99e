"""What is counted in worlds with learned front vehicles: feasible episodes, and how every vehicle's ended."""

from collections.abc import Mapping, Sequence
from typing import get_args

import numpy as np

from hhrl_bench.episodes import EpisodeRecords, TrafficRecords
from hhrl_bench.records import OutcomeName, RunTrafficRecord, TrafficRecord, metric_record
from hhrl_bench.statistics import Estimate, bootstrap_mean, wilson
from hhrl_bench.summaries import generator
from hhrl_envs import Outcome

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
