"""Sample efficiency: how many env steps a training takes until validation succeeds as often as the paper's method."""

from itertools import takewhile

import numpy as np

from hhrl_bench.censored import median
from hhrl_bench.efficiency_records import EfficiencyRecord
from hhrl_bench.metrics import finite
from hhrl_bench.training_records import TrainingOutcomesRecord
from hhrl_bench.transfer_metrics import THRESHOLD, Curve
from hhrl_bench.transfer_summary import censored_times, steps_to_threshold


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
