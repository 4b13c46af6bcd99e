"""One result of an entry, checked against the files it rests on."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hhrl_agents import METHODS, RULES
from hhrl_bench.errors import AgentError, RecordError
from hhrl_bench.evaluation.episodes import EpisodeRecords, TrafficRecords
from hhrl_bench.evaluation.evidence import Evidence, pack, unpack
from hhrl_bench.evaluation.loading import training_record
from hhrl_bench.evaluation.metrics import BUILT_IN, Metric, known_metrics, means
from hhrl_bench.evaluation.paired_evaluation import ScoredEpisodes
from hhrl_bench.evaluation.records import MetricsRecord, ResultRecord, RunMetricsRecord, RunRecord, TaskRecord
from hhrl_bench.evaluation.replay import replay
from hhrl_bench.evaluation.results import (
    count_traffic,
    over_episodes,
    result_record,
    run_record,
    summarise,
    summarise_traffic,
)
from hhrl_bench.evaluation.store import Store, read
from hhrl_bench.leaderboard.findings import Finding, differences
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.schema import Record, sha256_of
from hhrl_bench.tasks.tasks import SCRIPTED, Task, registered_task
from hhrl_bench.verification.identity import playable
from hhrl_envs import get_scenario
from hhrl_envs.arrays import Keys


def played_task(record: TaskRecord) -> Task:
    """Return the task as a record says that it was played.

    Raises:
        RecordError: if the opponent does not come with the package: to load it might be to run anybody's code.
    """
    task, opponent = registered_task(record.id), record.opponent.agent if record.opponent else SCRIPTED
    if task.opponent is None:
        return task
    if opponent not in {SCRIPTED, *RULES, *METHODS}:
        raise RecordError(f"the opponent {opponent!r} of {task.id} does not come with the package; play another one")
    return task.against(opponent)


_REPLAYED_ROWS = 10_000
"""Episodes that are played again side by side, if they are of several runs."""

_EPISODE_BYTES, _HEADER_BYTES = 256, 65_536
"""Room in evidence for the whole numbers of an episode, and for the names of all arrays."""


@dataclass
class CheckedResult:
    """A result at ``place`` in an entry, whose files lie in ``store``.

    checkpoints: whether those lie there as well; known: the whole numbers of each run, None where its evidence cannot
    be read. Decisions, which may be much of all runs together, are read again when they are needed.
    """

    place: str
    result: ResultRecord
    task_record: TaskRecord
    store: Store
    checkpoints: bool = True
    known: list[EpisodeRecords | None] = field(default_factory=list)

    @property
    def task(self) -> Task:
        """The task as it was played."""
        return played_task(self.task_record)

    @property
    def seeds(self) -> Keys:
        """The worlds that were played."""
        return self.task.test.take(self.task_record.episodes)

    def recompute(self, *, replayed: bool = False) -> Iterator[Finding]:
        """Return what differs from the whole numbers of the evidence, from the checkpoints, and within the result.

        Its intervals are left to `replay` if it is ``replayed`` too: they take longest, and are resampled once.
        """
        for place, run in self.runs():
            try:
                self.known.append(self.read(run).records(self.seeds))
            except RecordError as error:
                self.known.append(None)
                yield Finding(f"{place}.evidence_sha256", str(error))
            yield from self._check_training(place, run)
        known = [one for one in self.known if one is not None]
        if len(known) < len(self.known):
            return
        for (place, run), records in zip(self.runs(), known, strict=True):
            yield from _of_whole_numbers(f"{place}.metrics", run.metrics, records)
            yield from _differ(f"{place}.traffic", run.traffic, count_traffic(records))
        if not replayed:
            yield from self._check_metrics(known)
        yield from _differ(f"{self.place}.traffic", self.result.traffic, summarise_traffic(known))

    def replay(self) -> Iterator[Finding]:
        """Return what differs from what the stored decisions come to; the evidence has been read before."""
        if not self.readable:
            return
        together, every = max(1, _REPLAYED_ROWS // len(self.seeds)), list[EpisodeRecords]()
        for first in range(0, len(self.known), together):
            runs = self.runs()[first : first + together]
            try:
                evidence = [self.read(run) for _, run in runs]
                replayed = replay(evidence, self.task, self.seeds)
            except RecordError as error:
                yield Finding(f"{self.place}.runs", str(error))
                return
            for (place, run), kept, one in zip(runs, evidence, replayed, strict=True):
                found = list(self._of_decisions(f"{place}.evidence_sha256", kept, one))
                yield from found or _of_all(f"{place}.evidence_sha256", run, kept, one)
            every += [one.records for one in replayed]
        yield from self._check_replayed(every)

    def _check_replayed(self, every: Sequence[EpisodeRecords]) -> Iterator[Finding]:
        result = self.result
        runs = [
            run_record(run.checkpoint_sha256, run.training, records, run.evidence_sha256, _metrics(run, records))
            for run, records in zip(result.runs, every, strict=True)
        ]
        found = result_record(result.agent, result.kind, self.task, result.option, runs, every)
        found = found.model_copy(update={"failed_seeds": result.failed_seeds})
        yield from _differ(self.place, result, found)

    @property
    def playable(self) -> bool:
        """Whether its agents can be run again: they are rules, or their checkpoints are there."""
        return playable(self.result, checkpoints=self.checkpoints)

    @property
    def readable(self) -> bool:
        """Whether the evidence of every run has been read."""
        return len(self.known) == len(self.result.runs) and all(one is not None for one in self.known)

    def read(self, run: RunRecord) -> Evidence:
        """Return the evidence of a run.

        Raises:
            RecordError: if it is missing, damaged, too large, or of another number of episodes.
        """
        if run.evidence_sha256 is None:
            raise RecordError("no evidence is kept of this run")
        path = self.store.evidence(run.evidence_sha256)
        try:
            evidence = unpack(read(path, self._evidence_bytes))
        except RecordError as error:
            raise RecordError(f"{path.name}: {error}") from error
        if len(evidence.trace.steps) != self.task_record.episodes:
            raise RecordError(f"{path.name} has {len(evidence.trace.steps)} episodes, not {self.task_record.episodes}")
        return evidence

    def forget(self) -> None:
        """Drop what was read, which may be much of all results together."""
        self.known.clear()

    def runs(self) -> list[tuple[str, RunRecord]]:
        """Return the runs with their places."""
        return [(f"{self.place}.runs[{index}]", run) for index, run in enumerate(self.result.runs)]

    @property
    def _evidence_bytes(self) -> int:
        """The most that the evidence of so many episodes unpacks to."""
        scenario = get_scenario(self.task.scenario)
        vehicles = 1 + (scenario.learned_fronts or 0)
        return self.task_record.episodes * (2 * vehicles * scenario.horizon + _EPISODE_BYTES) + _HEADER_BYTES

    def _of_decisions(self, place: str, kept: Evidence, found: ScoredEpisodes) -> Iterator[Finding]:
        """Yield which whole numbers and decisions of others are not those that the agent's decisions come to."""
        records = found.records
        pairs: dict[str, tuple[NDArray[Any], NDArray[Any]]] = {
            "steps": (kept.steps, records.steps),
            "outcome": (kept.outcome, records.outcome),
            **{key: (ours, records.measured[key]) for key, ours in kept.measured.items()},
        }
        if isinstance(records, TrafficRecords):
            pairs |= {"outcomes": (kept.outcomes, records.outcomes), "feasible": (kept.feasible, records.feasible)}
        for name, (ours, theirs) in pairs.items():
            if not np.array_equal(ours, theirs):
                yield Finding(place, f"the {name} in it are not what the decisions in it come to")
        if not np.array_equal(kept.trace.actions, found.trace.actions):
            who = f"{self.task.opponent}, that" if self.task.opponent else "the vehicles that"
            yield Finding(place, f"the actions in it are not all those of {who} drives there")

    def _check_training(self, place: str, run: RunRecord) -> Iterator[Finding]:
        if run.checkpoint_sha256 is None:
            if run.training is not None:
                yield Finding(f"{place}.training", "a run without a checkpoint says that it was trained")
            return
        if not self.checkpoints:
            return
        path = self.store.checkpoint(run.checkpoint_sha256)
        try:
            found = training_record(self.store.checkpoint_metadata(run.checkpoint_sha256), path)
        except (AgentError, RecordError) as error:
            yield Finding(f"{place}.checkpoint_sha256", str(error))
            return
        yield from _differ(f"{place}.training", run.training, found)

    def _check_metrics(self, known: Sequence[EpisodeRecords]) -> Iterator[Finding]:
        place, metrics = f"{self.place}.metrics", self.result.metrics
        if len(known) > 1:
            yield from _differ(place, metrics, summarise([run.metrics for run in self.result.runs], known[0]))
            return
        for metric in _whole_metrics_of(metrics, known[0]):
            found = over_episodes(metric, metric.values(known[0]))
            yield from _differ(f"{place}.{metric.key}", metrics.get(metric.key), found)


def checked_results(board: LeaderboardRecord, store: Store) -> list[CheckedResult]:
    """Return the results of an entry, to be checked against the files in a store."""
    tasks = {task.id: task for task in board.tasks}
    return [
        CheckedResult(f"results[{index}]", result, tasks[result.task], store, board.checkpoints_published)
        for index, result in enumerate(board.results)
    ]


def _metrics(run: RunRecord, records: EpisodeRecords) -> list[Metric]:
    """Return the metrics that a run has to have: all that come with the package, and those of extensions it has."""
    return [metric for metric in known_metrics(records) if metric.key in BUILT_IN or metric.key in run.metrics]


def _of_all(place: str, run: RunRecord, kept: Evidence, found: ScoredEpisodes) -> Iterator[Finding]:
    """Yield whether evidence is not the file that its decisions come to, to the byte."""
    keys = {metric.key for metric in _metrics(run, found.records)} | kept.measured.keys()
    if sha256_of(pack(ScoredEpisodes(found.records.only(keys), found.trace))) != run.evidence_sha256:
        yield Finding(place, "it does not hold what the decisions in it come to, all of it and nothing else")


def _whole_metrics_of(record: MetricsRecord | RunMetricsRecord, known: EpisodeRecords) -> list[Metric]:
    """Return the metrics of a record that follow from what is known: from whole numbers alone."""
    return [metric for metric in record.declarations() if metric.follows_from(known.measured)]


def _of_whole_numbers(place: str, published: RunMetricsRecord, known: EpisodeRecords) -> Iterator[Finding]:
    for metric in published.declarations():
        if metric.is_whole and not metric.follows_from(known.measured):
            yield Finding(f"{place}.{metric.key}", "the evidence does not hold the numbers that it rests on")
    for key, found in means(known, _whole_metrics_of(published, known)).items():
        yield from differences(f"{place}.{key}", published.get(key), found)


def _differ(place: str, published: Record | None, found: Record | None) -> Iterator[Finding]:
    def plain(record: Record | None) -> Any:
        return record.model_dump() if record else None

    return differences(place, plain(published), plain(found))
