"""Sample efficiency: how many env steps a training takes until validation succeeds as often as the paper's method."""

from itertools import takewhile
from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from hhrl_bench.schema import FIRST, Count, Finite, Name, Positive, Rate, Record, finite
from hhrl_bench.statistics.censored_times import median
from hhrl_bench.training.learning_curves import THRESHOLD, Curve, TrainingOutcomesRecord
from hhrl_bench.transfer.records import StepsRecord
from hhrl_bench.transfer.summary import censored_times, steps_to_threshold


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
    seeds: Annotated[tuple[Count, ...], FIRST, Field(min_length=1)]
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


def efficiency(training: TrainingOutcomesRecord, rng: np.random.Generator) -> EfficiencyRecord:
    """Return the env steps to THRESHOLD of every seed, their median and its percentile bootstrap interval.

    The training has to be over: a seed that stopped before its end, because it failed, never reaches the threshold.

    Raises:
        CurveError: if the curves do not begin at step 0.
    """
    curves = [_curve(training, success) for success in training.testing.success]
    times, budget = censored_times(curves), training.env_steps[-1]
    _, _, low, high = median(times, budget, rng)
    slowest = max(range(len(curves)), key=lambda i: (times[i], -max(curves[i].success)))
    return EfficiencyRecord(
        method=training.method,
        task=training.task,
        threshold=THRESHOLD,
        budget=budget,
        seeds=training.seeds,
        steps=steps_to_threshold(curves),
        **finite({"low": low, "high": high}),
        slowest_seed=training.seeds[slowest],
    )


def _curve(training: TrainingOutcomesRecord, success: tuple[float | None, ...]) -> Curve:
    """Return a seed's curve as far as it has one."""
    rates = tuple(takewhile(lambda rate: rate is not None, success))
    return Curve(training.env_steps[: len(rates)], tuple(float(rate) for rate in rates if rate is not None))
