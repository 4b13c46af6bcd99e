"""How two agents compare on one task, as a record."""

from typing import Self

from pydantic import model_validator

from hhrl_bench.records import Finite, Name, Positive, Rate, Record
from hhrl_bench.statistics import IntervalKind


class DifferenceRecord(Record):
    """The mean of the agent less that of the other, with its 95% interval; null: unknown."""

    mean: Finite | None
    low: Finite | None
    high: Finite | None
    interval: IntervalKind


class ProbabilityRecord(Record):
    """The probability that a run of the agent has more of the metric than one of the other, with its 95% interval."""

    mean: Rate
    low: Rate
    high: Rate


class PairwiseRecord(Record):
    """An agent and the other one that it is compared to, by a metric in the same ``episodes`` worlds of a task.

    ``probability_more`` counts equal runs half; null where both agents have one run, which says nothing of others, or
    an agent has no such metric. Whether more is better, the metric says.
    """

    agent: Name
    other: Name
    task: Name
    metric: Name
    runs: Positive
    other_runs: Positive
    episodes: Positive
    difference: DifferenceRecord
    probability_more: ProbabilityRecord | None

    @model_validator(mode="after")
    def _compares_two(self) -> Self:
        if self.agent == self.other:
            raise ValueError(f"{self.agent} is compared to itself; name two agents")
        return self
