"""How soon a training reaches the threshold, as a record."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from hhrl_bench.records import Count, Finite, Name, Positive, Rate, Record
from hhrl_bench.transfer_records import StepsRecord


class EfficiencyRecord(Record):
    """Env steps to a validation success of ``threshold``, of every seed of a training of ``budget`` env steps.

    ``low`` and ``high`` bound the 95% interval of the median over the seeds, where ``high`` null is beyond the budget;
    both null: there is none, for a single seed. ``slowest_seed`` takes longest; of several that never get there, it is
    the one with the lowest best success.
    """

    method: Name
    task: Name
    threshold: Rate
    budget: Positive
    seeds: Annotated[tuple[Count, ...], Field(min_length=1)]
    steps: StepsRecord
    low: Finite | None
    high: Finite | None
    slowest_seed: Count

    @property
    def slowest(self) -> int | None:
        """The env steps of the slowest seed; None: it never reaches the threshold."""
        return self.steps.per_seed[self.seeds.index(self.slowest_seed)]

    @model_validator(mode="after")
    def _is_consistent(self) -> Self:
        if len(self.steps.per_seed) != len(self.seeds):
            raise ValueError("an efficiency has one time a seed; this one has not")
        if self.slowest_seed not in self.seeds:
            raise ValueError(f"the slowest seed {self.slowest_seed} is none of the seeds")
        return self
