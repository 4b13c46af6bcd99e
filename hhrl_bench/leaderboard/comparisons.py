"""Two agents compared in the same worlds: the difference of their means, and how likely a run of one has more.

A run is one policy: the only one of a rule, or one training seed of a learned method. The worlds are taken as given;
what varies is which policies training brings forth. Hence the bootstrap resamples the runs of each agent independently,
and an agent with a single run stays as it is. Between two single runs there is nothing of that kind, and it resamples
the worlds instead, the same ones for both.
"""

from collections.abc import Iterable, Sequence
from typing import NamedTuple, Self

import numpy as np
from pydantic import model_validator

from hhrl_bench.errors import RecordError
from hhrl_bench.schema import Finite, Name, Positive, Rate, Record, finite
from hhrl_bench.statistics.intervals import (
    CONFIDENCE,
    RESAMPLES,
    IntervalKind,
    bootstrap_mean,
    generator,
    weighted_sums,
)
from hhrl_envs.arrays import Floats, Ints


class Runs(NamedTuple):
    """An agent, and a metric of each of its runs in every world, [N] each; episode i is the same world in all."""

    agent: str
    values: Sequence[Floats]


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


def compare(a: Runs, b: Runs, task: str, metric: str, rng: np.random.Generator) -> PairwiseRecord:
    """Return how ``a`` compares to ``b`` by a metric on a task, with percentile bootstrap intervals.

    Raises:
        RecordError: if the runs are not of equally many episodes, one at least.
    """
    lengths = {len(values) for values in (*a.values, *b.values)}
    if len(lengths) != 1 or 0 in lengths:
        raise RecordError(f"runs of {a.agent} and {b.agent} are of {sorted(lengths)} episodes; compare equally many")
    several = max(len(a.values), len(b.values)) > 1
    x, y = (np.array([np.mean(values) for values in runs.values]) for runs in (a, b))
    known = bool(np.isfinite([*x, *y]).all())
    return PairwiseRecord(
        agent=a.agent,
        other=b.agent,
        task=task,
        metric=metric,
        runs=len(x),
        other_runs=len(y),
        episodes=lengths.pop(),
        difference=_over_runs(x, y, rng) if several else _over_worlds(a.values[0] - b.values[0], rng),
        probability_more=_probability_more(x, y, rng) if several and known else None,
    )


def draws(agent: str, other: str, task: str, metric: str) -> np.random.Generator:
    """Return the generator of a comparison's resamples, the same wherever these two are compared.

    Success adds nothing to its key: it was what agents were compared by alone.
    """
    return generator(f"{agent} {other} {task}" + ("" if metric == "success" else f" {metric}"))


def against(reference: str, comparisons: Iterable[PairwiseRecord]) -> list[PairwiseRecord]:
    """Return the comparisons that ``reference`` is part of, each turned so that it is the other agent."""
    turned = (_turned(one) if one.agent == reference else one for one in comparisons)
    return [one for one in turned if one.other == reference]


def shares_more(x: Floats, y: Floats) -> Floats:
    """Return 1 where x > y, 1/2 where they are equal, else 0, for all pairs of x [n] and y [m], [n, m].

    The mean is the Mann-Whitney statistic over n m, the probability of improvement of Agarwal et al. (2021), Deep
    Reinforcement Learning at the Edge of the Statistical Precipice.
    """
    return 0.5 * (np.sign(x[:, None] - y) + 1.0)


def _turned(one: PairwiseRecord) -> PairwiseRecord:
    difference, more = one.difference, one.probability_more
    ends = {"mean": difference.mean, "low": difference.high, "high": difference.low}
    negative = {name: None if value is None else 0.0 - value for name, value in ends.items()}
    rest = more and ProbabilityRecord(mean=1.0 - more.mean, low=1.0 - more.high, high=1.0 - more.low)
    return one.model_copy(
        update={
            "agent": one.other,
            "other": one.agent,
            "runs": one.other_runs,
            "other_runs": one.runs,
            "difference": difference.model_copy(update=negative),
            "probability_more": rest,
        }
    )


def _over_worlds(differences: Floats, rng: np.random.Generator) -> DifferenceRecord:
    mean, low, high, _, _, interval = bootstrap_mean(differences, rng, "bootstrap-episodes")
    return DifferenceRecord(**finite({"mean": mean, "low": low, "high": high}), interval=interval)


def _over_runs(x: Floats, y: Floats, rng: np.random.Generator) -> DifferenceRecord:
    mean = float(np.mean(x) - np.mean(y))
    if not np.isfinite(mean):
        return DifferenceRecord(mean=None, low=None, high=None, interval="none")
    low, high = _bounds(_resampled_mean(x, rng) - _resampled_mean(y, rng))
    return DifferenceRecord(mean=mean, low=low, high=high, interval="bootstrap-seeds")


def _probability_more(x: Floats, y: Floats, rng: np.random.Generator) -> ProbabilityRecord:
    more = shares_more(x, y)
    halves = (2.0 * more).astype(np.int64)  # whole numbers add up to the same in any order
    counted = ((_counts(len(x), rng) @ halves) * _counts(len(y), rng)).sum(axis=1)
    low, high = _bounds(counted / (2 * more.size))
    return ProbabilityRecord(mean=float(np.mean(more)), low=low, high=high)


def _resampled_mean(values: Floats, rng: np.random.Generator) -> Floats:
    """Return the mean of the values [n] in every resample, [RESAMPLES]."""
    return weighted_sums(_counts(len(values), rng) / len(values), values)


def _counts(n: int, rng: np.random.Generator) -> Ints:
    """Return how often each of n runs is in every resample, int64 [RESAMPLES, n]."""
    return rng.multinomial(n, np.full(n, 1.0 / n), size=RESAMPLES)


def _bounds(resampled: Floats) -> tuple[float, float]:
    tail = (1.0 - CONFIDENCE) / 2
    low, high = np.quantile(resampled, (tail, 1.0 - tail))
    return float(low), float(high)
