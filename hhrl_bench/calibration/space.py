"""What the calibration may change: the parameters of the paper's unpublished scenario, and the world they stand for.

The paper fixes the task and prints Table I, not the distributions behind it. Every parameter here is one of those
distributions' numbers, with a plausible range and the step that it is rounded to before a world is built from it.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.optimize import Bounds

from hhrl_envs import get_scenario
from hhrl_envs.arrays import Floats
from hhrl_envs.scenario.profiles import ProfileFamily, Range
from hhrl_envs.scenario.scenario import Reward, Road, Scenario, Traffic, Vehicle

SCENARIO_ID = "stop-line-paper-v0"


def guess() -> Floats:
    """Return the first guess, float64 [len(SPACE)]."""
    return np.array([parameter.guess for parameter in SPACE])


class Parameter(NamedTuple):
    """A number to fit: its range, the step it is rounded to, where to begin (a coarse earlier search), what it is."""

    name: str
    low: float
    high: float
    step: float
    guess: float
    meaning: str


SPACE = (
    Parameter("empty_share", 0.05, 0.2, 0.01, 0.1, "share of roads without a front vehicle"),
    Parameter("pair_share", 0.0, 0.6, 0.01, 0.28, "share of roads with two front vehicles"),
    Parameter("start_distance", 25.0, 80.0, 1.0, 37.0, "ego's least distance to the line at the start [m]"),
    Parameter("start_spread", 0.0, 30.0, 1.0, 11.0, "width of that distance's range [m]"),
    Parameter("start_speed", 3.0, 10.0, 0.5, 6.0, "ego's least speed at the start [m/s]"),
    Parameter("start_speed_spread", 0.0, 5.0, 0.5, 2.5, "width of that speed's range [m/s]"),
    Parameter("speed_limit", 8.0, 16.0, 0.5, 13.5, "speed limit [m/s]"),
    Parameter("gap", 2.0, 20.0, 0.5, 6.0, "least gap between vehicles at the start [m]"),
    Parameter("gap_spread", 0.0, 20.0, 0.5, 12.0, "width of that gap's range [m]"),
    Parameter("front_speed", 2.0, 10.0, 0.5, 5.5, "front vehicles' least speed at the start [m/s]"),
    Parameter("front_speed_spread", 0.0, 5.0, 0.5, 4.0, "width of that speed's range [m/s]"),
    Parameter("desired_speed", 5.0, 12.0, 0.5, 8.5, "front vehicles' least desired speed [m/s]"),
    Parameter("desired_speed_spread", 0.0, 4.0, 0.5, 3.5, "width of that speed's range [m/s]"),
    Parameter(
        "front_accel", 0.8, 3.0, 0.1, 1.7, "front vehicles' least maximum acceleration, 0.5 below the most [m/s^2]"
    ),
    Parameter("dwell", 0.5, 6.0, 0.1, 3.0, "front vehicles' shortest pause at the line [s]"),
    Parameter("dwell_spread", 0.0, 4.0, 0.1, 1.7, "width of that pause's range [s]"),
    Parameter("abrupt_share", 0.02, 0.6, 0.01, 0.4, "share of front vehicles that stop abruptly ahead of the line"),
    Parameter("abrupt_decel", 5.0, 8.0, 0.1, 7.5, "their least deceleration for the line, 1 below the most [m/s^2]"),
    Parameter("abrupt_position", 3.0, 30.0, 1.0, 12.0, "where they stop, 3 either way [m before the line]"),
    Parameter("past_share", 0.02, 0.35, 0.01, 0.17, "share of front vehicles that stop past the line"),
    Parameter("past_position", 0.5, 4.0, 0.1, 1.4, "where they stop at the least, at the most 4 [m past the line]"),
    Parameter("lag", 0.1, 1.5, 0.05, 1.4, "time constant of the ego's actuator [s]"),
    Parameter("jerk_limit", 1.0, 20.0, 0.5, 6.0, "jerk limit of the ego's actuator [m/s^3]"),
    Parameter("max_decel", 3.0, 9.0, 0.1, 6.0, "a_max of Eq. (dis), nominal [m/s^2]"),
    Parameter("safe_gap", 1.0, 8.0, 0.1, 1.5, "d_0 of Eq. (dis) [m]"),
    Parameter("jerk_threshold", 1.0, 60.0, 0.1, 25.0, "jerk above which a step is unsmooth [m/s^3]"),
)
"""Everything that is fitted. What is not named here is as in ``stop-line-v0``."""


def bounds() -> Bounds:
    """Return the range of every parameter of the space."""
    return Bounds([parameter.low for parameter in SPACE], [parameter.high for parameter in SPACE])


def named(vector: Floats) -> dict[str, float]:
    """Return the parameters of a vector float64 [len(SPACE)], rounded to their steps."""
    return {
        parameter.name: round(round(value / parameter.step) * parameter.step, 6)
        for parameter, value in zip(SPACE, vector.tolist(), strict=True)
    }


def build(values: Mapping[str, float]) -> Scenario:
    """Return the world that the parameters, by name, stand for."""
    v = values
    alone = round(1.0 - v["empty_share"] - v["pair_share"], 6)
    start_speed = _range(v["start_speed"], v["start_speed_spread"], v["speed_limit"])
    return replace(
        get_scenario("stop-line-v0"),
        id=SCENARIO_ID,
        traffic=Traffic(
            families=_families(v),
            count_shares=(v["empty_share"], alone, v["pair_share"]),
            gap=_range(v["gap"], v["gap_spread"]),
            speed=_range(v["front_speed"], v["front_speed_spread"]),
        ),
        vehicle=Vehicle(lag=v["lag"], jerk_limit=v["jerk_limit"], max_decel=v["max_decel"]),
        road=Road(
            speed_limit=v["speed_limit"],
            start_distance=_range(v["start_distance"], v["start_spread"]),
            start_speed=start_speed,
        ),
        reward=Reward(jerk_threshold=v["jerk_threshold"], safe_gap=v["safe_gap"]),
    )


def _families(v: Mapping[str, float]) -> tuple[ProfileFamily, ...]:
    ordinary = ProfileFamily(
        "ordinary",
        round(1.0 - v["abrupt_share"] - v["past_share"], 6),
        desired_speed=_range(v["desired_speed"], v["desired_speed_spread"]),
        max_accel=_range(v["front_accel"], 0.5),
        dwell=_range(v["dwell"], v["dwell_spread"]),
    )
    abrupt = replace(
        ordinary,
        name="abrupt",
        weight=v["abrupt_share"],
        line_decel=_range(v["abrupt_decel"], 1.0),
        stop_position=_range(v["abrupt_position"] - 3.0, 6.0),
    )
    past = replace(ordinary, name="past-the-line", weight=v["past_share"], stop_position=(-4.0, -v["past_position"]))
    return ordinary, abrupt, past


def _range(low: float, width: float, most: float = np.inf) -> Range:
    return (min(low, most), min(round(low + width, 6), most))
