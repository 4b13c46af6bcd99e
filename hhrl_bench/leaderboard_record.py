"""The record of a leaderboard file."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from hhrl_bench.records import Count, Name, ProvenanceRecord, Rate, Record, ResultRecord, TaskRecord
from hhrl_bench.transfer_records import TransferSetRecord


class LeaderboardRecord(Record):
    """What ``hhrl-bench run`` and ``transfer`` write: agents on tasks and, of a transfer, what every arm comes to.

    A result of an arm has the method and the arm as its agent.
    """

    schema_version: Literal[1]
    suite: Name
    confidence: Rate
    bootstrap_seed: Count
    tasks: Annotated[tuple[TaskRecord, ...], Field(min_length=1)]
    results: tuple[ResultRecord, ...]
    transfer: TransferSetRecord | None = None
    provenance: ProvenanceRecord

    @model_validator(mode="after")
    def _results_are_of_known_tasks_and_unique(self) -> Self:
        known = {task.id for task in self.tasks}
        names = [(result.task, result.agent) for result in self.results]
        for task, agent in names:
            if task not in known:
                raise ValueError(f"{agent} has a result on {task}, which is not among the tasks")
            if names.count((task, agent)) > 1:
                raise ValueError(f"{agent} has two results on {task}; keep one")
        return self
