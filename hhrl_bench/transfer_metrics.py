"""What transfer is worth, from two success curves of one seed: A begins with a source policy, B from scratch.

Jumpstart, asymptotic gain, time to threshold and transfer ratio are those of Taylor and Stone (2009), Transfer Learning
for Reinforcement Learning Domains: A Survey; forward transfer is that of Wolczyk et al. (2021), Continual
World. A curve is known at its reports alone; between two of them the area takes it to be a straight line.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from hhrl_bench.errors import CurveError

THRESHOLD = 0.93
"""The success rate of Hybrid HRL in Table I of Qiao et al. (2020)."""


@dataclass(frozen=True, slots=True)
class Curve:
    """One seed's validation success rates [T] at ``env_steps`` [T], from step 0 to the budget, which is the last one.

    Raises:
        CurveError: if there is no report, the steps do not ascend from 0, or a success is no rate.
    """

    env_steps: tuple[int, ...]
    success: tuple[float, ...]

    def __post_init__(self) -> None:
        """Reject what is no curve."""
        steps, success = self.env_steps, self.success
        if not steps or len(steps) != len(success):
            raise CurveError(f"a curve has {len(steps)} steps and {len(success)} successes; write one success a step")
        if steps[0] != 0 or any(after <= before for before, after in pairwise(steps)):
            raise CurveError(f"the env steps of a curve are {_short(steps)}; write ascending ones that begin with 0")
        if not all(0.0 <= rate <= 1.0 for rate in success):
            raise CurveError(f"the successes of a curve are {_short(success)}; write rates of 0 to 1")


def jumpstart(a: Curve, b: Curve) -> float:
    """Return A(0) - B(0), what the source policy is ahead before any training."""
    _require_one_grid(a, b)
    return a.success[0] - b.success[0]


def asymptotic_gain(a: Curve, b: Curve) -> float:
    """Return A(T) - B(T) at the last report: what is gained for good, as far as the budget T shows it."""
    _require_one_grid(a, b)
    return a.success[-1] - b.success[-1]


def time_to_threshold(curve: Curve) -> int | None:
    """Return the env steps of the first report with a success of at least THRESHOLD; None: censored, never reached.

    It is as coarse as the reports, and a lucky report counts: compare it between curves with the same reports alone.
    """
    reached = (steps for steps, rate in zip(curve.env_steps, curve.success, strict=True) if rate >= THRESHOLD)
    return next(reached, None)


def area(curve: Curve) -> float:
    """Return the area under the curve by the trapezoid rule, over the budget: the mean success, in [0, 1].

    That of a single report is its success.
    """
    if len(curve.success) == 1:
        return curve.success[0]
    steps, success = np.array(curve.env_steps), np.array(curve.success)
    return float(np.sum(np.diff(steps) * (success[1:] + success[:-1])) / (2 * steps[-1]))


def transfer_ratio(a: Curve, b: Curve) -> float | None:
    """Return (area of A - area of B) / area of B; None: undefined, as B has no area."""
    _require_one_grid(a, b)
    below = area(b)
    return (area(a) - below) / below if below > 0.0 else None


def forward_transfer(a: Curve, b: Curve) -> float | None:
    """Return (area of A - area of B) / (1 - area of B), 1 at best; None: undefined, as B leaves nothing to gain."""
    _require_one_grid(a, b)
    below = area(b)
    return (area(a) - below) / (1.0 - below) if below < 1.0 else None


def _require_one_grid(a: Curve, b: Curve) -> None:
    if a.env_steps != b.env_steps:
        raise CurveError(
            f"two curves have reports at {_short(a.env_steps)} and {_short(b.env_steps)} env steps; "
            "compare curves with the same reports"
        )


def _short(values: tuple[float, ...]) -> str:
    """Return the values, or the first and last ones of many, for a message."""
    words = [f"{value:.12g}" for value in values]
    return ", ".join(words if len(words) <= 6 else [*words[:4], "...", words[-1]])
