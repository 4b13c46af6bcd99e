"""How the ranking by score depends on the weights of the score: each of them moved by half, either way."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Literal, get_args

import numpy as np
from pydantic import Field
from scipy.stats import spearmanr

from hhrl_bench.evaluation.metric import Measured
from hhrl_bench.evaluation.score import WEIGHTS, Weights, score
from hhrl_bench.schema import Name, Positive, Record

Part = Literal["progress", "comfort", "margin"]

FACTORS = (0.5, 1.5)
"""What a weight is multiplied with."""

MOVED: Mapping[tuple[Part, float], Weights] = {
    (part, factor): replace(WEIGHTS, **{part: factor * getattr(WEIGHTS, part)})
    for part in get_args(Part)
    for factor in FACTORS
}
"""The weights in which one is moved, by its name and the factor."""

_DIGITS = 9  # of scores that are ranked, and of correlations: powers differ between machines in the last bits


class SensitivityRecord(Record):
    """Spearman's correlation of the ranking of a task's ``agents`` by score with the one by a score of other weights.

    In that one the weight of a ``part`` is multiplied with ``factor``. Null: the agents have equal scores in one of
    them. An oracle is no rival, and not ranked.
    """

    task: Name
    part: Part
    factor: Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
    agents: Positive
    rank_correlation: Annotated[float, Field(ge=-1.0, le=1.0)] | None


def rescored(run: Measured) -> list[float]:
    """Return the mean score of a run's episodes, by our weights and by each of those in `MOVED`."""
    return [float(np.mean(score(run, weights))) for weights in (WEIGHTS, *MOVED.values())]


def sensitivity(task: str, scores: Sequence[Sequence[float]]) -> Iterator[SensitivityRecord]:
    """Yield what moving each weight does to the ranking of a task's agents, given what `rescored` returns of them."""
    ours, *others = np.round(np.array(scores), _DIGITS).T
    for (part, factor), moved in zip(MOVED, others, strict=True):
        ranked = np.unique(ours).size > 1 and np.unique(moved).size > 1
        correlation = round(float(spearmanr(ours, moved).statistic), _DIGITS) if ranked else None
        yield SensitivityRecord(task=task, part=part, factor=factor, agents=len(scores), rank_correlation=correlation)
