"""The metrics: every number that agents are scored by, declared once.

The records of episodes and of results, the JSON schema, tables, comparisons and the checks of verification derive from
``METRICS``. To add a metric, add its declaration here, or give it to ``register_metric`` in a module of your own and
name that module: ``hhrl-bench --extension MODULE_OR_FILE.py``.
"""

from collections.abc import Callable
from typing import Literal

import numpy as np

from hhrl_bench.evaluation import score
from hhrl_bench.evaluation.metric import (
    METRICS,
    Ending,
    Least,
    Measured,
    Metric,
    OfWorld,
    Sum,
    columns,
    compared,
    known_metrics,
    mean,
    means,
    metric_error,
    register_metric,
    watched,
)
from hhrl_bench.evaluation.rollout import Step
from hhrl_envs import Outcome
from hhrl_envs.arrays import Floats, Ints
from hhrl_envs.simulation import rewards

__all__ = [
    "BUILT_IN",
    "HEADLINE",
    "METRICS",
    "Ending",
    "Least",
    "Measured",
    "Metric",
    "OfWorld",
    "Sum",
    "columns",
    "compared",
    "known_metrics",
    "mean",
    "means",
    "metric_error",
    "of_selected",
    "register_metric",
    "watched",
]

HEADLINE = "score"
"""The metric that agents are ranked by, where an entry has it."""

LONGEST_TTC = 10.0
"""Seconds; a longer time to collision counts as that: how much longer says nothing about danger."""


def of_selected(by_option: Floats, option: Ints) -> Floats:
    """Return the rewards [B] of the selected options, given those of all options [B, K]; NaN where none is selected."""
    selected = np.full(len(option), np.nan)
    for k in range(by_option.shape[1]):
        np.copyto(selected, by_option[:, k], where=option == k)
    return selected


def _unsafe(step: Step) -> Floats:
    unsafe: Floats = -step.results.terms[:, rewards.UNSAFE].sum(axis=1)
    return unsafe


def _time_to_collision(step: Step) -> Floats:
    return np.minimum(step.time_to_collision, LONGEST_TTC)


_COLLISION = int(Outcome.COLLISION)  # numpy compares with a plain integer in a fifth of the time


def _impact_speed(step: Step) -> Floats:
    return np.where(step.results.outcomes == _COLLISION, step.closing, np.nan)


def _ends_in(outcome: Outcome) -> Callable[[Ending], Floats]:
    return lambda ending: np.asarray(ending.outcome == outcome, np.float64)


def _rate(outcome: Outcome, better: Literal["higher", "lower"], *, compared: bool = False) -> Metric:
    key = outcome.name.lower()
    heading, meaning = key.replace("_", " "), f"share of the episodes that end in {outcome.name}"
    return Metric(
        key, heading, _ends_in(outcome), meaning, digits=1, bound_digits=1, better=better, is_rate=True, nullable=False,
        required=True, watched=True, compared=compared,
    )  # fmt: skip


def _of_score(key: str, of: Callable[[Measured], Floats], meaning: str, needs: tuple[str, ...]) -> Metric:
    return Metric(key, key, of, meaning, better="higher", nullable=False, table="score", needs=needs)


for _metric in (
    Metric(
        "return_task", "r^task", Sum(lambda step: step.results.rewards), "undiscounted sum of r^task",
        bound_digits=1, better="higher", nullable=False, required=True, watched=True, table=None,
    ),
    Metric(
        "return_option", "r^o", Sum(lambda step: of_selected(step.results.reward_option, step.option)),
        "undiscounted sum of r^option of the selected options; none for flat agents",
        bound_digits=1, better="higher", required=True, watched=True,
    ),
    Metric(
        "return_action", "r^a", Sum(lambda step: of_selected(step.results.reward_action, step.option)),
        "undiscounted sum of r^action of the selected options; none for flat agents",
        bound_digits=1, better="higher", required=True, watched=True,
    ),
    Metric(
        "steps", "step", lambda ending: np.asarray(ending.steps, np.float64), "environment steps",
        digits=1, bound_digits=1, nullable=False, required=True, watched=True,
    ),
    Metric(
        "unsmooth", "unsmooth", Sum(lambda step: step.results.terms[:, rewards.UNSMOOTH] < 0.0, whole=True),
        "steps with too large a jerk", better="lower", nullable=False, required=True, watched=True,
    ),
    Metric(
        "unsafe", "unsafe", Sum(_unsafe), "sum of the unsafe penalties of all sub-goals, positive",
        better="lower", nullable=False, required=True, watched=True,
    ),
    _rate(Outcome.COLLISION, "lower"),
    _rate(Outcome.NOT_STOP, "lower"),
    _rate(Outcome.TIMEOUT, "lower"),
    _rate(Outcome.SUCCESS, "higher", compared=True),
    Metric(
        "impact_speed", "impact\nm/s", Least(_impact_speed),
        "speed relative to the front vehicle at a collision; none without one",
        unit="m/s", better="lower", required=True, table="worst cases",
    ),
    Metric(
        "smallest_gap", "smallest\ngap, m", Least(lambda step: step.gap),
        "smallest free road to a front vehicle; none if there never was one in range",
        unit="m", better="higher", required=True, table="worst cases",
    ),
    Metric(
        "smallest_ttc", "smallest\nTTC, s", Least(_time_to_collision),
        "smallest free road over closing speed (time to collision), at most 10 s; none if the gap never closed",
        unit="s", better="higher", required=True, table="worst cases",
    ),
    Metric(
        "fewest_steps", "fewest\nsteps", OfWorld(score.fewest_steps),
        "steps of the quickest way to the goal, whoever drives, found by the oracle; 0 where it found none",
        digits=1, bound_digits=1, nullable=False, table="score",
    ),
    Metric(
        "uncomfortable", "uncomfortable\nsteps", Sum(score.uncomfortable, whole=True),
        "steps with an acceleration or a jerk beyond the bounds of comfort",
        digits=1, bound_digits=1, better="lower", nullable=False, table="score",
    ),
    Metric(
        "too_close", "too close\nsteps", Sum(score.too_close, whole=True),
        "steps nearer to the front vehicle than the margin",
        digits=1, bound_digits=1, better="lower", nullable=False, table="score",
    ),
    _of_score(
        "progress", score.progress, "the fewest steps as a share of those taken, at most 1", ("fewest_steps",)
    ),
    _of_score("comfort", score.comfort, "share of the steps that are comfortable", ("uncomfortable",)),
    _of_score("margin", score.margin, "share of the steps that keep the margin", ("too_close",)),
    Metric(
        HEADLINE, "score", score.score, "progress, comfort and margin in one number from 0 to 1; 0 without success",
        digits=3, bound_digits=3, better="higher", nullable=False, compared=True,
        needs=("fewest_steps", "uncomfortable", "too_close"),
    ),
):  # fmt: skip
    register_metric(_metric)

BUILT_IN = frozenset(METRICS)
"""The keys of the metrics that come with the package: no entry may leave one out that its episodes have."""
