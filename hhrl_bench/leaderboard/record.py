"""The record of a leaderboard file, and the parts of it that follow from the others."""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import combinations
from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from pydantic import AfterValidator, Field, JsonValue, ValidationError, model_validator

from hhrl_bench.errors import RecordError
from hhrl_bench.evaluation.evidence import read_evidence
from hhrl_bench.evaluation.metrics import HEADLINE, METRICS, compared
from hhrl_bench.evaluation.records import ResultRecord, TaskRecord
from hhrl_bench.evaluation.store import Store
from hhrl_bench.leaderboard.comparisons import PairwiseRecord, Runs, against, compare, draws
from hhrl_bench.leaderboard.efficiency import EfficiencyRecord, efficiency
from hhrl_bench.leaderboard.sensitivity import SensitivityRecord, rescored, sensitivity
from hhrl_bench.provenance import ProvenanceRecord
from hhrl_bench.schema import FIRST, MAX_RESULTS, Count, Name, Rate, Record, Sha256, Stem, first_problem
from hhrl_bench.statistics.intervals import generator
from hhrl_bench.training.learning_curves import TrainingOutcomesRecord
from hhrl_bench.transfer.records import TransferSetRecord
from hhrl_envs.arrays import Floats

MAX_COMPARED = 50
"""Results on a task; every two of them are compared."""

MAX_EPISODES = 400_000
"""Episodes of all runs of an entry."""

MAX_RESULT_EPISODES = 100_000
"""Episodes of all runs of a result, whose records are held together while it is checked."""

MAX_RESAMPLED = 2_000_000
"""Episodes that intervals resample: those of a single run for every metric that is no rate, and those of every two
single runs on a task for every metric that is compared."""

MAX_PAIRS = 1_000_000
"""Pairs of runs of every two results on a task, for every metric that is compared, of which is counted who has more."""

MAX_WORLDS = 50_000
"""Worlds of all tasks, in each of which the oracle looks for the quickest way."""

MAX_TRAINED = 1_000_000_000
"""Env steps of the trainings of all checkpoints, each counted once."""

MAX_CURVES = 10_000
"""Learning curves of all seeds of trainings and of the arms of transfers, whose numbers are resampled."""

MAX_SETTINGS = 2**16
"""Letters of all settings of a method."""


def _short(config: dict[str, JsonValue]) -> dict[str, JsonValue]:
    if len(json.dumps(config)) > MAX_SETTINGS:
        raise ValueError(f"a method's settings are longer than {MAX_SETTINGS:,} letters")
    return config


class MethodRecord(Record):
    """A method: all of its settings, and their hash."""

    id: Name
    config_hash: Name
    config: Annotated[dict[str, JsonValue], AfterValidator(_short)]


class LeaderboardRecord(Record):
    """What ``hhrl-bench run`` and ``transfer`` write: agents on tasks; of a transfer, what every arm comes to.

    A result of an arm has the method and the arm as its agent. ``methods``: those that runs were trained by.
    ``checkpoints_published``: whether the checkpoints lie beside the file; if not, the command trains them again.
    ``comparisons``: of every two agents on a task; ``sensitivity``: of the ranking by score to the score's weights.
    ``trainings``: how the episodes of trainings ended;
    ``efficiency``: the env steps that each of them needs; ``trainings_sha256``: their digests, as nothing else in the
    entry could tell whether a number of a curve has been changed.
    """

    schema_version: Literal[1]
    suite: Stem
    confidence: Rate
    bootstrap_seed: Count
    tasks: Annotated[tuple[TaskRecord, ...], FIRST, Field(min_length=1, max_length=100)]
    results: Annotated[tuple[ResultRecord, ...], FIRST, Field(min_length=1, max_length=MAX_RESULTS)]
    checkpoints_published: bool = True
    methods: Annotated[tuple[MethodRecord, ...], FIRST, Field(max_length=MAX_RESULTS)] = ()
    comparisons: Annotated[tuple[PairwiseRecord, ...], FIRST] = ()
    sensitivity: Annotated[tuple[SensitivityRecord, ...], FIRST] = ()
    transfer: TransferSetRecord | None = None
    trainings: Annotated[tuple[TrainingOutcomesRecord, ...], FIRST, Field(max_length=MAX_RESULTS)] = ()
    trainings_sha256: Annotated[tuple[Sha256, ...], FIRST] = ()
    efficiency: Annotated[tuple[EfficiencyRecord, ...], FIRST] = ()
    provenance: ProvenanceRecord

    def on(self, task: TaskRecord) -> list[ResultRecord]:
        """Return the results on a task, in their order."""
        return [result for result in self.results if result.task == task.id]

    def find(self, agent: str, task: str) -> ResultRecord:
        """Return the result of an agent on a task.

        Raises:
            RecordError: if there is none.
        """
        for result in self.results:
            if (result.agent, result.task) == (agent, task):
                return result
        known = ", ".join(f"{result.agent} on {result.task}" for result in self.results)
        raise RecordError(f"the entry has no {agent} on {task}; it has {known}")

    @model_validator(mode="after")
    def _all_are_of_known_tasks_and_unique(self) -> Self:
        ids = [task.id for task in self.tasks]
        if len(set(ids)) < len(ids):
            raise ValueError(f"the tasks {', '.join(ids)} name one twice; keep one")
        self._require("result", [(result.agent, result.task) for result in self.results])
        self._require("training", [(training.method, training.task) for training in self.trainings])
        self._require_bounds()
        return self

    def _require_bounds(self) -> None:
        """Refuse what would take long to check: every episode is played again, every two results are compared."""
        for count, most, what in self._costs():
            if count > most:
                raise ValueError(f"{what} {count:,}, and at most {most:,} can be published")

    def _costs(self) -> Iterator[tuple[int, int, str]]:
        """Yield how much there is to check, how much there may be at most, and of what."""
        for task in self.tasks:
            yield len(self.on(task)), MAX_COMPARED, f"results on {task.id}:"
        episodes = {task.id: task.episodes for task in self.tasks}
        of_results = [len(one.runs) * episodes[one.task] for one in self.results]
        for one, count in zip(self.results, of_results, strict=True):
            yield count, MAX_RESULT_EPISODES, f"episodes of {one.agent} on {one.task}:"
        yield sum(of_results), MAX_EPISODES, "episodes of all results:"
        yield sum(episodes.values()), MAX_WORLDS, "worlds of all tasks:"
        resampled = sum(task.episodes * self._resamplings(task) for task in self.tasks)
        yield resampled, MAX_RESAMPLED, "episodes of single runs that intervals resample:"
        pairs = (pair for task in self.tasks for pair in combinations(self.on(task), 2))
        paired = sum(len(one.runs) * len(other.runs) for one, other in pairs)
        yield paired * len(compared()), MAX_PAIRS, "pairs of runs that are compared:"
        arms = self.transfer.rows if self.transfer else ()
        curves = [*(one.seeds for one in self.trainings), *(one.seeds for one in arms)]
        yield sum(map(len, curves)), MAX_CURVES, "learning curves of all seeds:"
        yield self._trained_steps(), MAX_TRAINED, "env steps of all trainings:"

    def _trained_steps(self) -> int:
        """Return how many env steps it takes to train every seed again, those of an arm after its source's."""
        budgets: dict[str | None, int] = {}
        trained: dict[object, tuple[int, str | None]] = {}
        for index, result in enumerate(self.results):
            for run in result.runs:
                if training := run.training:
                    budgets[run.checkpoint_sha256] = training.budget or 0
                    key = run.checkpoint_sha256, None if self.checkpoints_published else index
                    trained[key] = training.budget or 0, training.source_sha256
            if shared := result.runs[0].training:
                trained |= {(index, seed): (shared.budget or 0, None) for seed in result.failed_seeds}
        return sum(steps + budgets.get(source, 0) for steps, source in trained.values())

    def _resamplings(self, task: TaskRecord) -> int:
        single = sum(len(result.runs) == 1 for result in self.on(task))
        means = sum(not metric.is_rate for metric in METRICS.values())
        return means * single + len(compared()) * single * (single - 1) // 2

    def _require(self, what: str, names: Sequence[tuple[str, str]]) -> None:
        known = [task.id for task in self.tasks]
        for agent, task in names:
            if task not in known:
                raise ValueError(f"{agent} has a {what} on {task}, which is not among the tasks {', '.join(known)}")
            if names.count((agent, task)) > 1:
                raise ValueError(f"{agent} has two {what}s on {task}; keep one")


def derived_fields(
    results: Sequence[ResultRecord], trainings: Sequence[TrainingOutcomesRecord], store: Store, *, checkpoints: bool
) -> dict[str, Any]:
    """Return the fields of a leaderboard that follow from its results, its trainings and their files.

    With ``checkpoints`` the store has those of the results; the methods are known from them.

    Raises:
        RecordError: if a file of the results is missing or damaged.
    """
    runs = [run for result in results for run in result.runs]
    hashes = dict.fromkeys(run.checkpoint_sha256 for run in runs if run.checkpoint_sha256 and checkpoints)
    return {
        "methods": method_records(map(store.checkpoint_metadata, hashes)),
        **_of_episodes(results, store),
        "trainings_sha256": tuple(training.digest() for training in trainings),
        "efficiency": tuple(efficiency(one, generator(f"{one.method} on {one.task}")) for one in trainings),
    }


class _Played(NamedTuple):
    """What is compared of a result's episodes: the metrics by their keys, and the scores by all weights, if any."""

    runs: Mapping[str, Runs]
    scores: Sequence[float] | None


def _of_episodes(results: Sequence[ResultRecord], store: Store) -> dict[str, Any]:
    """Return the fields that compare the results on a task by what happened in their episodes."""
    played = [_played(result, store) for result in results]
    return {
        "comparisons": tuple(_comparisons(results, [one.runs for one in played])),
        "sensitivity": tuple(_sensitivity(results, [one.scores for one in played])),
    }


def _played(result: ResultRecord, store: Store) -> _Played:
    """Return the same of the runs of a result, whose evidence is read and dropped again run by run."""
    values: dict[str, list[Floats]] = {metric.key: [] for metric in compared() if metric.key in result.metrics}
    scores: list[Sequence[float]] = []
    for run in result.runs:
        evidence = read_evidence(run, store)
        for key, of_runs in values.items():
            of_runs.append(METRICS[key].values(evidence))
        if HEADLINE in result.metrics:
            scores.append(rescored(evidence))
    runs = {key: Runs(result.agent, of_runs) for key, of_runs in values.items()}
    return _Played(runs, np.mean(scores, axis=0).tolist() if scores else None)


def _comparisons(results: Sequence[ResultRecord], runs: Sequence[Mapping[str, Runs]]) -> Iterator[PairwiseRecord]:
    """Yield the comparison of every two results on a task, in their order, by every metric that both have."""
    for (result, a), (other, b) in combinations(zip(results, runs, strict=True), 2):
        if result.task == other.task:
            for key in (key for key in a if key in b):
                rng = draws(result.agent, other.agent, result.task, key)
                yield compare(a[key], b[key], result.task, key, rng)


def _sensitivity(
    results: Sequence[ResultRecord], scores: Sequence[Sequence[float] | None]
) -> Iterator[SensitivityRecord]:
    """Yield what the weights of the score change in the ranking of each task on which there are several agents."""
    by_task: dict[str, list[Sequence[float]]] = {}
    for result, own in zip(results, scores, strict=True):
        if own is not None and result.kind != "oracle":
            by_task.setdefault(result.task, []).append(own)
    for task, of_agents in by_task.items():
        if len(of_agents) > 1:
            yield from sensitivity(task, of_agents)


def method_records(metadata: Iterable[Mapping[str, Any]]) -> tuple[MethodRecord, ...]:
    """Return the methods that checkpoints with these metadata were trained by, each once, in their order.

    Raises:
        RecordError: if the metadata do not say so.
    """
    return tuple({record.config_hash: record for record in map(_record, metadata)}.values())


def _record(metadata: Mapping[str, Any]) -> MethodRecord:
    given = {"id": metadata.get("method"), **{key: metadata.get(key) for key in ("config_hash", "config")}}
    try:
        return MethodRecord.model_validate(given)
    except ValidationError as error:
        raise RecordError(f"a checkpoint says of its method what cannot be: {first_problem(error)}") from error


def standing(result: ResultRecord) -> tuple[bool, bool, float]:
    """Return what a result is ranked by; the greater one is better.

    It is the score, from 0 to 1, or how often it succeeds where there is no score: those without a score come behind
    those with one, and an oracle, which is not ranked, behind all.
    """
    score: float | None = getattr(result.metrics.get(HEADLINE), "mean", None)
    return result.kind != "oracle", score is not None, (result.metrics.success.mean or 0.0) if score is None else score


def compared_to_best(board: LeaderboardRecord, task: TaskRecord) -> list[PairwiseRecord]:
    """Return the comparisons of every other agent to the best one of a task, in the order of the results.

    An oracle is no rival: it is never the best one.
    """
    best = max(board.on(task), key=standing, default=None)
    if best is None or best.kind == "oracle":
        return []
    return against(best.agent, (one for one in board.comparisons if one.task == task.id))
