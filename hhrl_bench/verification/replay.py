"""Replaying: stored decisions played through the simulator again, which gives the same episodes on every machine."""

from collections.abc import Sequence
from dataclasses import fields

import numpy as np

from hhrl_bench.errors import RecordError
from hhrl_bench.evaluation.decisions import Trace, recordings
from hhrl_bench.evaluation.episodes import EpisodeRecords
from hhrl_bench.evaluation.evaluate import play
from hhrl_bench.evaluation.evidence import Evidence
from hhrl_bench.evaluation.rollout import evaluation_slots
from hhrl_bench.tasks.seeds import UInt64Array
from hhrl_bench.tasks.tasks import Task
from hhrl_envs import Option, get_scenario


def replay(evidence: Sequence[Evidence], task: Task, seeds: UInt64Array) -> list[EpisodeRecords]:
    """Return the records of each policy's episodes in the worlds ``seeds`` uint64 [N], played from their traces.

    Raises:
        RecordError: if the traces cannot be those of such episodes.
    """
    scenario, slots = get_scenario(task.scenario), evaluation_slots(task)
    traces = [one.trace for one in evidence]
    for trace in traces:
        _require_fit(trace, len(slots), 1 + (scenario.learned_fronts or 0), len(seeds), scenario.num_actions)
    together = Trace(*(np.concatenate(arrays) for arrays in zip(*traces, strict=True)))
    agent, drivers = recordings(together, slots)
    worlds = np.tile(seeds, len(traces))
    records = play(agent, scenario, worlds, rows=len(worlds), drivers=drivers).records
    return [_part(records, slice(first, first + len(seeds))) for first in range(0, len(worlds), len(seeds))]


def _require_fit(trace: Trace, own: int, driven: int, episodes: int, levels: int) -> None:
    if len(trace.steps) != episodes:
        raise RecordError(f"the trace has {len(trace.steps)} episodes, not {episodes}")
    if trace.options.shape[1] != own or trace.actions.shape[1] not in {driven, 1}:
        raise RecordError(f"the trace drives {trace.actions.shape[1]} vehicles, which this task does not")
    known = bool((trace.options >= -1).all() and (trace.options < len(Option)).all())
    if not known or trace.actions.min() < 0 or trace.actions.max() >= levels:
        raise RecordError("the trace holds an option or action that this scenario does not have")


def _part(records: EpisodeRecords, rows: slice) -> EpisodeRecords:
    kind = type(records)
    return kind(**{field.name: getattr(records, field.name)[rows] for field in fields(kind)})
