"""What transfer is worth, from two success curves of one seed: A begins with a source policy, B from scratch.

Jumpstart, asymptotic gain, time to threshold and transfer ratio are those of Taylor and Stone (2009), Transfer Learning
for Reinforcement Learning Domains: A Survey; forward transfer is that of Wolczyk et al. (2021), Continual
World. A curve is known at its reports alone; between two of them the area takes it to be a straight line.
"""

from hhrl_bench.errors import CurveError
from hhrl_bench.training.learning_curves import Curve, area, listed


def jumpstart(a: Curve, b: Curve) -> float:
    """Return A(0) - B(0), what the source policy is ahead before any training."""
    _require_one_grid(a, b)
    return a.success[0] - b.success[0]


def asymptotic_gain(a: Curve, b: Curve) -> float:
    """Return A(T) - B(T) at the last report: what is gained for good, as far as the budget T shows it."""
    _require_one_grid(a, b)
    return a.success[-1] - b.success[-1]


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
            f"two curves have reports at {listed(a.env_steps)} and {listed(b.env_steps)} env steps; "
            "compare curves with the same reports"
        )
