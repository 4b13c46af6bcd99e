"""How the controllers of a rule drive: numbers with units and bounds."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from math import inf
from typing import Literal, NamedTuple

COMFORT = 2.0
"""Deceleration that a controller plans with [m/s^2]."""


class Bounds(NamedTuple):
    """Between which values of a number a search looks, and its unit; ``"1"`` for a share."""

    low: float
    high: float
    unit: str


def _number(default: float, low: float, high: float, unit: str) -> float:
    return field(default=default, metadata={"bounds": Bounds(low, high, unit)})


@dataclass(frozen=True)
class Tuning:
    """How the controllers of an agent drive.

    The defaults are those of `RulePlus`. Its deceleration is the comfortable one of the other rules; the rest of what
    it uses was chosen once, for the highest mean return on the first 2,000 validation worlds of stop-line-v0; the
    optimum is flat. `bounds` says the units, and where a search looks. Where candidates drive side by side, a number
    may be an array with one for each row.

    Attributes:
        headway: time gap to the front vehicle.
        decel: deceleration that stops at the line are planned with; those of the "idm" behind a front vehicle too.
        gap_margin: what the gap at a standstill exceeds d_0 of Eq. (dis) by; a gap below d_0 counts as unsafe.
        response: time in which a speed error is removed.
        accel: highest acceleration that the follower asks for.
        predicted: whether the state that they are given is that of `predict`, so that no controller has to reckon
            with the actuator's lag.
        follower: the controller of FFV, a name in ``controllers.FOLLOWERS``.
        front_decel: deceleration that the "safe speed" is planned with.
        leader_decel: deceleration that the "safe speed" expects of the front vehicle.
        aim: where the stop zone is aimed at, as a share of its length before the line.
        speed_share: highest speed, as a share of the speed limit.
        lags, delays: how far ahead the state is predicted: this share of the actuator's lag and that of the sensor's
            delay.
        jerk: highest jerk that a change of level may cause while the brakes are not urgent.
        urgent: deceleration from which they are, if a controller asks for it.
        hidden: speed of a front vehicle that may be just out of sight, as a share of the speed limit; with 1 the road
            there counts as free, with 0 it is as if a standing vehicle were there.
    """

    headway: float = _number(1.5, 0.0, 2.5, "s")
    decel: float = _number(COMFORT, 0.5, 5.0, "m/s^2")
    gap_margin: float = _number(1.0, -1.0, 3.0, "m")
    response: float = _number(1.0, 0.1, 1.5, "s")
    accel: float = _number(1.5, 0.6, 2.5, "m/s^2")
    predicted: bool = True
    follower: Literal["idm", "safe speed"] = "idm"
    front_decel: float = _number(COMFORT, 0.5, 5.0, "m/s^2")
    leader_decel: float = _number(COMFORT, 1.5, 9.0, "m/s^2")
    aim: float = _number(0.5, 0.1, 0.95, "1")
    speed_share: float = _number(1.0, 0.4, 1.0, "1")
    lags: float = _number(1.0, 0.0, 1.5, "1")
    delays: float = _number(0.0, 0.0, 1.5, "1")
    jerk: float = _number(inf, 2.0, 30.0, "m/s^3")
    urgent: float = _number(inf, 1.0, 8.0, "m/s^2")
    hidden: float = _number(1.0, 0.0, 1.0, "1")


PLUS_TUNING = Tuning()
"""How `RulePlus` drives."""

PAPER_TUNING = Tuning(headway=1.0, response=0.5, accel=2.0, predicted=False)
"""How the rules of Table I drive. The headway is short, for the rule that always follows collides in 18% there."""

FIRST_TUNING = Tuning(
    follower="safe speed",
    headway=0.5,
    decel=2.5,
    gap_margin=0.4,
    response=0.4,
    accel=2.0,
    front_decel=2.5,
    leader_decel=4.0,
    aim=0.8,
    speed_share=0.95,
    delays=0.5,
    jerk=4.13,
    urgent=4.5,
    hidden=0.5,
)
"""Where the searches for `tuned_rule` begin. No jerk exceeds the bound of comfort unless the brakes are urgent."""


def bounds() -> Mapping[str, Bounds]:
    """Return the bounds of all numbers of a `Tuning`, by their names."""
    return {one.name: one.metadata["bounds"] for one in fields(Tuning) if "bounds" in one.metadata}
