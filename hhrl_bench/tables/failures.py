"""Failures: how episodes end that do not succeed, by the driver in front, and how severe they are."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from hhrl_bench.evaluation.metrics import METRICS, Metric
from hhrl_bench.statistics.intervals import wilson
from hhrl_bench.tables.table import Cell, Column, Group, Note, Row, Table, number_cell
from hhrl_bench.text import NONE

Episodes = Mapping[str, Sequence[Any]]
"""The columns of episodes; see ``hhrl_bench.exports.episodes``."""


class AgentEpisodes(NamedTuple):
    """An agent's episodes of ``runs`` policies, one after the other."""

    agent: str
    runs: int
    episodes: Episodes


_NOTES = (
    Note("Profile: the family of the driver in front of the ego, the nearest one. Causes: how many episodes end so."),
    Note("Intervals: Wilson, of agents with a single policy.", without_intervals=""),
    Note("Impact and overrun: means over the episodes that have one."),
)


def failures_table(agents: Sequence[AgentEpisodes], severity: Sequence[Metric], title: str) -> Table:
    """Return a group for each agent: all of its episodes, then those behind each profile.

    severity: the metrics that say how severe a failure is.
    """
    causes = [
        key for key, metric in METRICS.items() if metric.is_rate and any(key in one.episodes["cause"] for one in agents)
    ]
    columns = [Column("episodes"), Column("failed"), *(Column(cause.replace("_", "\n")) for cause in causes)]
    groups = [Group(one.agent, tuple(_rows(one, causes, severity))) for one in agents]
    return Table(
        title, "profile in front", (*columns, *(Column(one.heading) for one in severity)), tuple(groups), _NOTES
    )


def _rows(one: AgentEpisodes, causes: Sequence[str], severity: Sequence[Metric]) -> list[Row]:
    profiles = np.array(one.episodes["profile"])
    every = np.ones(len(profiles), np.bool_)
    parts = {"all": every, **{name: profiles == name for name in sorted(set(profiles.tolist()))}}
    return [Row(name, _cells(one, np.flatnonzero(part), causes, severity)) for name, part in parts.items()]


def _cells(one: AgentEpisodes, chosen: Any, causes: Sequence[str], severity: Sequence[Metric]) -> tuple[Cell, ...]:
    ended = [one.episodes["cause"][index] for index in chosen]
    failed = sum(cause is not None for cause in ended)
    bounds = wilson(failed, len(ended)) if one.runs == 1 else None
    rate = number_cell(METRICS["success"], failed / len(ended), bounds and bounds.low, bounds and bounds.high)
    counts = [Cell(f"{len(ended):,}"), rate, *(Cell(f"{ended.count(cause):,}") for cause in causes)]
    return (*counts, *(_mean(one.episodes[metric.key], chosen, metric) for metric in severity))


def _mean(values: Sequence[float | None], chosen: Any, metric: Metric) -> Cell:
    known = [value for index in chosen if (value := values[index]) is not None]
    return number_cell(metric, float(np.mean(known))) if known else Cell(NONE)
