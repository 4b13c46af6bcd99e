"""Replay: the episodes that stored decisions come to, run through the simulator again, to the last bit."""

from collections.abc import Iterable, Sequence
from typing import Protocol

import numpy as np

from hhrl_agents.training.drivers import Drivers
from hhrl_bench.errors import RecordError
from hhrl_bench.evaluation import decisions, episodes
from hhrl_bench.evaluation.decisions import Trace, episodes_of, recording
from hhrl_bench.evaluation.metrics import Metric
from hhrl_bench.evaluation.paired_evaluation import ScoredEpisodes, evaluation_drivers, play
from hhrl_bench.tasks.tasks import Task
from hhrl_envs import Option, Scenario, get_scenario
from hhrl_envs.arrays import Keys

ROWS = 2_000
"""Episodes that are played again side by side; more take more memory and no less time."""


class Traced(Protocol):
    """What has the trace of episodes: evidence, or episodes that were just played."""

    @property
    def trace(self) -> Trace:
        """Every decision."""


def replay(
    runs: Sequence[Traced], task: Task, seeds: Keys, metrics: Iterable[Metric] | None = None
) -> list[ScoredEpisodes]:
    """Return each policy's episodes in the worlds ``seeds`` uint64 [N], run again from its decisions, side by side.

    Who else drives in the task decides again for itself, whatever the traces say. By default with all metrics.

    Raises:
        RecordError: if the traces cannot be those of such episodes.
    """
    scenario, drivers = get_scenario(task.scenario), evaluation_drivers(task)
    for one in runs:
        require_fit(one.trace, drivers, len(seeds), scenario)
    traces = [one.trace for one in runs]
    trace, worlds = decisions.join(traces, len(seeds) * len(runs)), np.tile(seeds, len(runs))
    chosen = None if metrics is None else list(metrics)
    played = []
    for first in range(0, len(worlds), ROWS):
        part = slice(first, first + ROWS)
        agent, rows = recording(episodes_of(trace, part), drivers.slots), len(worlds[part])
        played.append(play(agent, scenario, worlds[part], rows=rows, drivers=drivers, metrics=chosen))
    records = episodes.join([one.records for one in played], len(worlds))
    again = decisions.join([one.trace for one in played], len(worlds))
    parts = [slice(begin, begin + len(seeds)) for begin in range(0, len(worlds), len(seeds))]
    return [ScoredEpisodes(records.part(part), episodes_of(again, part)) for part in parts]


def require_fit(trace: Trace, drivers: Drivers, count: int, scenario: Scenario) -> None:
    """Raise a ``RecordError`` if a trace cannot be that of so many episodes in which these drive."""
    own, driven = len(drivers.slots), len(drivers.slots) + len(drivers.others)
    if len(trace.steps) != count:
        raise RecordError(f"the trace has {len(trace.steps)} episodes, not {count}")
    if trace.options.shape[1] != own or trace.actions.shape[1] != driven:
        raise RecordError(f"the trace drives {trace.actions.shape[1]} vehicles, in this task agents drive {driven}")
    known = bool((trace.options >= -1).all() and (trace.options < len(Option)).all())
    if not known or trace.actions.min() < 0 or trace.actions.max() >= scenario.num_actions:
        raise RecordError("the trace holds an option or action that this scenario does not have")
