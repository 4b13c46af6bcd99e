"""The least and the largest value of every number of a scenario, with its unit, in one place.

They keep to what makes physical sense, with room to spare, so that a world ends and its arithmetic holds: whoever
brakes comes to a stand, nothing is divided by next to nothing, and no vehicle gets to where absent ones are kept.
"""

from collections.abc import Mapping
from typing import NamedTuple

from hhrl_envs.scenario.validation import Rule, interval, number


class Limits(NamedTuple):
    """The values that a number may have: from ``low`` to ``high``, in a ``unit``."""

    low: float
    high: float
    unit: str


_CONSTANT, _FREE = Limits(0.0, 1e6, "a number"), (0.0, 1000.0)

VEHICLE = {
    "levels": Limits(-100.0, 100.0, "m/s^2"),
    "lag": Limits(0.0, 100.0, "seconds"),
    "jerk_limit": Limits(0.1, 1e6, "m/s^3"),
    "max_decel": Limits(0.1, 100.0, "m/s^2"),
    "length": Limits(0.1, 100.0, "metres"),
}
WEAKEST = 0.1  # m/s^2; full brake and full throttle are at least this

ROAD = {
    "speed_limit": Limits(0.1, 100.0, "m/s"),
    "lines": Limits(0.0, 500.0, "metres"),
    "stop_zone": Limits(0.01, 500.0, "metres"),
    "stop_speed": Limits(0.001, 100.0, "m/s"),
    "friction": Limits(0.01, 1.5, "a coefficient"),
    "start_distance": Limits(0.0, 500.0, "metres"),
    "start_speed": Limits(0.0, 100.0, "m/s"),
}
SLIPPERY = {"share": Limits(0.0, 1.0, "a share"), "friction": ROAD["friction"]}

SIGNAL = {"green_at": Limits(0.0, 1e5, "seconds")}

BAND = {
    "low": Limits(0.0, 1000.0, "metres"),
    "high": Limits(0.1, 1000.0, "metres"),
    "headway": Limits(0.0, 1000.0, "seconds"),
    "share": Limits(0.001, 1.0, "a share"),
}

SENSOR = {
    "front_range": Limits(0.1, 1000.0, "metres"),
    "line_range": Limits(0.1, 1000.0, "metres"),
    "noise_distance": Limits(0.0, 1000.0, "a standard deviation in metres"),
    "noise_speed": Limits(0.0, 1000.0, "a standard deviation in m/s"),
    "noise_accel": Limits(0.0, 1000.0, "a standard deviation in m/s^2"),
    "delay": Limits(0, 50, "steps"),
    "dropout": Limits(0.0, 0.95, "a share"),
    "dropout_time": Limits(0.001, 1000.0, "seconds"),
}
GHOSTS = {
    "share": Limits(0.0, 1.0, "a share"),
    "stretch": Limits(10.0, 1000.0, "metres"),
    "near": Limits(0.5, 1000.0, "metres"),
}

TRAFFIC = {"gap": Limits(1.0, 1000.0, "metres"), "speed": Limits(0.0, 100.0, "m/s")}
MOST_FRONTS = 100

REWARD = {
    **dict.fromkeys(("sigma_1", "sigma_2", "sigma_3", "sigma_4", "jerk_threshold", "timeout_scale"), _CONSTANT),
    "safe_gap": Limits(0.1, 1000.0, "metres"),
}

ADVERSARY = {"hardest_brake": Limits(0.1, 100.0, "m/s^2"), "patience": Limits(0.0, 1e5, "seconds")}

SCENARIO = {
    "route_end": Limits(0.1, 1e4, "metres"),
    "dt": Limits(0.001, 1.0, "seconds"),
    "horizon": Limits(1, 20_000, "steps"),
    "learned_fronts": Limits(0, MOST_FRONTS, "front vehicles"),
}
LONGEST = 3600.0  # s; an hour at the highest speeds is still short of where absent vehicles are kept

PROFILE: Mapping[str, Limits] = {
    "desired_speed": Limits(0.1, 100.0, "m/s"),
    "headway": Limits(*_FREE, "s"),
    "max_accel": Limits(0.1, 100.0, "m/s^2"),
    "comfort_decel": Limits(0.1, 100.0, "m/s^2"),
    "min_gap": Limits(*_FREE, "m"),
    "line_decel": Limits(0.1, 100.0, "m/s^2"),
    "stop_position": Limits(-4.0, 50.0, "m before the line"),
    "line_speed": Limits(*_FREE, "m/s at the line"),
    "dwell": Limits(*_FREE, "s"),
    "start_delay": Limits(*_FREE, "s"),
    "slow_at": Limits(-1000.0, 1000.0, "m before the line"),
    "slow_decel": Limits(*_FREE, "m/s^2"),
    "slow_time": Limits(*_FREE, "s"),
    "slow_every": Limits(1.0, 1e6, "m"),
}
"""The limits of every profile parameter, in the order of the fields of a vehicle's record from PROFILE on."""

FAMILY = {"weight": Limits(1e-6, 1e6, "a number"), "slow_chance": Limits(0.0, 1.0, "a share")}


def numbers(known: Mapping[str, Limits], *fields: str) -> dict[str, Rule]:
    """Return the rules of fields that are numbers within their limits."""
    return {field: number(*known[field]) for field in fields}


def intervals(known: Mapping[str, Limits], *fields: str) -> dict[str, Rule]:
    """Return the rules of fields that are ranges within their limits."""
    return {field: interval(*known[field]) for field in fields}
