"""What a transfer study says, as records: every arm's success curves, and what they come to over scratch.

A source policy of ``method``, trained on the task ``source``, is used on the task ``target`` in up to three ways, its
``arm``: zero-shot, not trained any more; frozen-action, the action level frozen and the option level learned anew;
fine-tune, all of it trained on. The control is scratch: the same method from nothing, with the same seeds and budget.
"""

from collections.abc import Sequence
from typing import Annotated, Any, Literal, NamedTuple, Self

from pydantic import Field, model_validator

from hhrl_bench.schema import FIRST, MAX_REPORTS, MAX_RESULTS, MAX_SEEDS, Count, Finite, Name, Positive, Rate, Record
from hhrl_bench.training.learning_curves import Curve
from hhrl_bench.transfer.transfer import CONTROL, ArmName


class SeedsMetricRecord(Record):
    """A metric of every seed, null where it is undefined, with the mean and 95% interval of the ``n`` defined ones."""

    per_seed: Annotated[tuple[Finite | None, ...], FIRST]
    mean: Finite | None
    low: Finite | None
    high: Finite | None
    n: Count


class StepsRecord(Record):
    """Env steps to the threshold and their median, null: not within the budget; how many seeds reached it."""

    per_seed: Annotated[tuple[Count | None, ...], FIRST]
    median: Finite | None
    reached: Count


class StepsRatioRecord(Record):
    """The median env steps to the threshold over those of scratch: from ``at_least`` to ``at_most``, with 95% interval.

    The two are one number unless a median lies beyond the budget. ``at_most`` null, and ``high`` null: without bound;
    ``low`` null: there is no interval, for a single seed.
    """

    at_least: Finite
    at_most: Finite | None
    low: Finite | None
    high: Finite | None


class ComparisonRecord(Record):
    """What an arm is worth over scratch; a steps ratio below 1 is faster."""

    jumpstart: SeedsMetricRecord
    asymptotic_gain: SeedsMetricRecord
    transfer_ratio: SeedsMetricRecord
    forward_transfer: SeedsMetricRecord
    steps_ratio: StepsRatioRecord


class TransferRecord(Record):
    """One arm on one target: success rates [seeds, reports] on validation episodes at ``env_steps`` [reports].

    ``budget`` is the last report's env steps; zero-shot keeps its success all along. ``start``, ``final`` and ``area``
    are the success at step 0, at the last report, and on the average in between. ``over_scratch`` is null for scratch,
    whose ``source`` is that of the arms it is the control of.
    """

    source: Name
    target: Name
    method: Name
    arm: ArmName
    seeds: Annotated[tuple[Count, ...], FIRST, Field(min_length=1, max_length=MAX_SEEDS)]
    budget: Positive
    threshold: Rate
    env_steps: Annotated[tuple[Count, ...], FIRST, Field(min_length=1, max_length=MAX_REPORTS)]
    success: Annotated[tuple[Annotated[tuple[Rate, ...], FIRST], ...], FIRST]
    start: SeedsMetricRecord
    final: SeedsMetricRecord
    area: SeedsMetricRecord
    steps_to_threshold: StepsRecord
    over_scratch: ComparisonRecord | None

    @property
    def group(self) -> "ArmGroup":
        """The group of arms that it belongs to."""
        return ArmGroup(self.method, self.source, self.target)

    @model_validator(mode="after")
    def _is_consistent(self) -> Self:
        for rates in self.success:
            Curve(self.env_steps, rates)
        _require(list(self.seeds) == sorted(set(self.seeds)), "its seeds ascend")
        _require(len(self.success) == len(self.seeds), "it has one success curve a seed")
        _require(self.budget == self.env_steps[-1], "its budget is the last of its env steps")
        _require(
            self.arm != "zero-shot" or all(len({*rates}) == 1 for rates in self.success), "zero-shot does not learn"
        )
        _require((self.arm == CONTROL) == (self.over_scratch is None), "all arms but scratch are compared to it")
        _require(all(len(row) == len(self.seeds) for row in self._per_seed()), "its metrics have one value a seed")
        return self

    def _per_seed(self) -> Sequence[Sequence[Any]]:
        parts = [self, *([self.over_scratch] if self.over_scratch else [])]
        metrics = [getattr(part, name) for part in parts for name in type(part).model_fields]
        return [one.per_seed for one in metrics if isinstance(one, SeedsMetricRecord | StepsRecord)]


class ArmGroup(NamedTuple):
    """What the arms of one comparison share."""

    method: str
    source: str
    target: str

    def __str__(self) -> str:
        return f"{self.method} from {self.source} on {self.target}"


class TransferSetRecord(Record):
    """The arms of a transfer study; every group of them is bootstrapped anew from ``bootstrap_seed``."""

    schema_version: Literal[1]
    confidence: Rate
    bootstrap_seed: Count
    rows: Annotated[tuple[TransferRecord, ...], FIRST, Field(min_length=1, max_length=MAX_RESULTS)]

    @model_validator(mode="after")
    def _arms_are_unique_and_have_a_control(self) -> Self:
        arms = [(row.group, row.arm) for row in self.rows]
        for group, arm in arms:
            if arms.count((group, arm)) > 1:
                raise ValueError(f"{group} has {arm} twice; keep one")
            if (group, CONTROL) not in arms:
                raise ValueError(f"{group} has no {CONTROL}; add it, as the other arms are compared to it")
        return self


def _require(holds: bool, rule: str) -> None:
    if not holds:
        raise ValueError(f"a transfer record is such that {rule}; this one is not")
