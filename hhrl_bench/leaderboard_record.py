"""The record of a leaderboard file."""

from collections.abc import Sequence
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from hhrl_bench.comparison_records import PairwiseRecord
from hhrl_bench.efficiency_records import EfficiencyRecord
from hhrl_bench.method_records import MethodRecord
from hhrl_bench.records import Count, Name, ProvenanceRecord, Rate, Record, ResultRecord, Sha256, TaskRecord
from hhrl_bench.training_records import TrainingOutcomesRecord
from hhrl_bench.transfer_records import TransferSetRecord


class LeaderboardRecord(Record):
    """What ``hhrl-bench run`` and ``transfer`` write: agents on tasks; of a transfer, what every arm comes to.

    A result of an arm has the method and the arm as its agent. ``methods``: those that runs were trained by.
    ``checkpoints_published``: whether the checkpoints lie beside the file; if not, the command trains them again.
    ``comparisons``: of the success of every two agents on a task. ``trainings``: how the episodes of trainings ended;
    ``efficiency``: the env steps that each of them needs; ``trainings_sha256``: their digests, as nothing else in the
    entry could tell whether a number of a curve has been changed.
    """

    schema_version: Literal[1]
    suite: Name
    confidence: Rate
    bootstrap_seed: Count
    tasks: Annotated[tuple[TaskRecord, ...], Field(min_length=1)]
    results: tuple[ResultRecord, ...]
    checkpoints_published: bool = True
    methods: tuple[MethodRecord, ...] = ()
    comparisons: tuple[PairwiseRecord, ...] = ()
    transfer: TransferSetRecord | None = None
    trainings: tuple[TrainingOutcomesRecord, ...] = ()
    trainings_sha256: tuple[Sha256, ...] = ()
    efficiency: tuple[EfficiencyRecord, ...] = ()
    provenance: ProvenanceRecord

    def on(self, task: TaskRecord) -> list[ResultRecord]:
        """Return the results on a task, in their order."""
        return [result for result in self.results if result.task == task.id]

    @model_validator(mode="after")
    def _all_are_of_known_tasks_and_unique(self) -> Self:
        ids = [task.id for task in self.tasks]
        if len(set(ids)) < len(ids):
            raise ValueError(f"the tasks {', '.join(ids)} name one twice; keep one")
        self._require("result", [(result.agent, result.task) for result in self.results])
        self._require("training", [(training.method, training.task) for training in self.trainings])
        return self

    def _require(self, what: str, names: Sequence[tuple[str, str]]) -> None:
        known = {task.id for task in self.tasks}
        for agent, task in names:
            if task not in known:
                raise ValueError(f"{agent} has a {what} on {task}, which is not among the tasks")
            if names.count((agent, task)) > 1:
                raise ValueError(f"{agent} has two {what}s on {task}; keep one")
