"""Scenarios: worlds as frozen, validated, hashable data.

A scenario says what the road, the ego, the traffic and the reward are; the simulator is the same for all of them.
Lengths are metres, times seconds, speeds m/s, accelerations m/s^2, jerk m/s^3. The stop-line stands at position 0, the
ego starts at a negative position and drives towards it.
"""

import hashlib
import json
from dataclasses import asdict, dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from hhrl_envs import layout, observation
from hhrl_envs.errors import InputError
from hhrl_envs.options import Option
from hhrl_envs.profiles import ProfileFamily, Range, family_table

WALKING_PACE = 1.4  # m/s; the speed at which a feasible episode leaves time to reach the freed stop zone


def _require(holds: bool, name: str, value: object, allowed: str) -> None:
    if not holds:
        raise InputError(f"{name} is {value}; write {allowed}")


def _require_range(name: str, value: Range, low: float, high: float = inf) -> None:
    _require(low <= value[0] <= value[1] <= high, name, value, f"(low, high) with {low} <= low <= high <= {high}")


@dataclass(frozen=True)
class Vehicle:
    """The ego's actuator: its acceleration follows the chosen level through a first-order lag and a jerk limit.

    ``levels`` are the target accelerations that the discrete actions stand for, ascending. ``max_decel`` is a_max of
    Eq. (dis), the nominal deceleration that the state's safety distances are computed with.
    """

    levels: tuple[float, ...] = (-6.0, -3.0, -1.5, 0.0, 1.0, 2.0)
    lag: float = 0.3
    jerk_limit: float = 15.0
    max_decel: float = 6.0
    length: float = 5.0

    def __post_init__(self) -> None:
        """Reject values without a meaning."""
        _require(
            len(self.levels) >= 2 and list(self.levels) == sorted(set(self.levels)),
            "levels",
            self.levels,
            "at least two accelerations, ascending",
        )
        _require(
            self.levels[0] < 0.0 < self.levels[-1],
            "levels",
            self.levels,
            "levels from a brake below 0 to a throttle above 0",
        )
        _require(0.0 <= self.lag < inf, "lag", self.lag, "seconds, 0 or more")
        _require(0.0 < self.jerk_limit < inf, "jerk_limit", self.jerk_limit, "m/s^3 above 0")
        _require(0.0 < self.max_decel < inf, "max_decel", self.max_decel, "m/s^2 above 0")
        _require(0.0 < self.length < inf, "length", self.length, "metres above 0")


@dataclass(frozen=True)
class Road:
    """The approach: speed limit, stop window ``0 <= d_d <= stop_zone`` at ``v_e < stop_speed``, sensor, starts."""

    speed_limit: float = 12.0
    stop_zone: float = 2.0
    stop_speed: float = 0.1
    sensor_range: float = 100.0
    start_distance: Range = (55.0, 85.0)
    start_speed: Range = (5.0, 10.0)

    def __post_init__(self) -> None:
        """Reject values without a meaning."""
        _require(0.0 < self.speed_limit < inf, "speed_limit", self.speed_limit, "m/s above 0")
        _require(0.0 < self.stop_zone < inf, "stop_zone", self.stop_zone, "metres above 0")
        _require(0.0 < self.stop_speed < inf, "stop_speed", self.stop_speed, "m/s above 0")
        _require(0.0 < self.sensor_range < inf, "sensor_range", self.sensor_range, "metres above 0")
        _require_range("start_distance", self.start_distance, self.stop_zone)
        _require_range("start_speed", self.start_speed, 0.0, self.speed_limit)


@dataclass(frozen=True)
class Traffic:
    """The scripted front vehicles: how many (shares of 0, 1, 2, ... vehicles), how far apart, how fast, and who drives.

    ``gap`` is the free road between two vehicles at the start, bumper to bumper.
    """

    families: tuple[ProfileFamily, ...]
    count_shares: tuple[float, ...] = (0.1, 0.3, 0.3, 0.2, 0.1)
    gap: Range = (8.0, 25.0)
    speed: Range = (5.0, 12.0)

    def __post_init__(self) -> None:
        """Reject values without a meaning."""
        total = sum(self.count_shares)
        _require(
            min(self.count_shares, default=-1.0) >= 0.0 and abs(total - 1.0) < 1e-9,
            "count_shares",
            self.count_shares,
            "shares of 0, 1, 2, ... front vehicles that add up to 1",
        )
        _require(len(self.families) > 0, "families", self.families, "at least one profile family")
        _require_range("gap", self.gap, 1.0)
        _require_range("speed", self.speed, 0.0)

    @property
    def max_fronts(self) -> int:
        """The largest number of front vehicles that can be drawn."""
        return len(self.count_shares) - 1


@dataclass(frozen=True)
class Reward:
    """The constants of the paper's reward: sigma_1 time, sigma_2 jerk, sigma_3 collision, sigma_4 success.

    The defaults are those that the paper's Table I implies. ``safe_gap`` is d_0 of Eq. (dis). The paper gives its jerk
    threshold of 1 no unit; here it is in m/s^3. ``timeout_scale`` multiplies the timeout penalty d_d^2 (1 is the
    paper's).
    """

    sigma_1: float = 0.01
    sigma_2: float = 2.5
    sigma_3: float = 36.0
    sigma_4: float = 49.0
    jerk_threshold: float = 4.0
    positive_jerk_only: bool = False
    safe_gap: float = 5.0
    timeout_scale: float = 0.01

    def __post_init__(self) -> None:
        """Reject values without a meaning."""
        for name in ("sigma_1", "sigma_2", "sigma_3", "sigma_4", "jerk_threshold", "timeout_scale"):
            _require(0.0 <= getattr(self, name) < inf, name, getattr(self, name), "a number, 0 or more")
        _require(0.0 < self.safe_gap < inf, "safe_gap", self.safe_gap, "metres above 0")


@dataclass(frozen=True)
class Scenario:
    """A world with a versioned id. ``feasible_only`` rejects, at reset, worlds in which no ego could succeed."""

    id: str
    traffic: Traffic
    vehicle: Vehicle = Vehicle()
    road: Road = Road()
    reward: Reward = Reward()
    dt: float = 0.1
    horizon: int = 600
    feasible_only: bool = True

    def __post_init__(self) -> None:
        """Reject values without a meaning."""
        _require(0.0 < self.dt <= 1.0, "dt", self.dt, "seconds in (0, 1]")
        _require(self.horizon >= 1, "horizon", self.horizon, "a number of steps, at least 1")

    @property
    def num_actions(self) -> int:
        """The number of discrete throttle and brake levels."""
        return len(self.vehicle.levels)

    @property
    def num_vehicles(self) -> int:
        """The largest number of vehicles on the road, the ego included."""
        return self.traffic.max_fronts + 1

    @property
    def option_mask(self) -> tuple[bool, bool]:
        """Which of the global options exist here: SSL always, FFV where there is traffic."""
        return (True, self.traffic.max_fronts > 0)

    @property
    def spec_hash(self) -> str:
        """The SHA-256 of the scenario's data: equal hashes mean equal worlds."""
        return _digest(asdict(self))

    @property
    def interface_hash(self) -> str:
        """The SHA-256 of what an agent sees and answers: observation, option and action sets."""
        sets = {
            "observation": [observation.SYMBOLS, observation.SCALES.tolist()],
            "options": [option.name for option in Option],
            "levels": self.vehicle.levels,
        }
        return _digest(sets)

    def constants(self) -> NDArray[np.float64]:
        """Return the scenario's numbers as the kernels' packed array, float64 [CONSTANTS_SIZE]."""
        c = np.zeros(layout.CONSTANTS_SIZE)
        v, road, reward, traffic = self.vehicle, self.road, self.reward, self.traffic
        c[[layout.DT, layout.HORIZON, layout.LENGTH]] = self.dt, self.horizon, v.length
        c[[layout.LAG_GAIN, layout.JERK_STEP]] = self.dt / (v.lag + self.dt), v.jerk_limit * self.dt
        c[layout.EGO_MIN_ACCEL] = v.levels[0]
        c[[layout.SPEED_LIMIT, layout.STOP_ZONE, layout.STOP_SPEED]] = road.speed_limit, road.stop_zone, road.stop_speed
        c[layout.SENSOR_RANGE] = road.sensor_range
        c[layout.CLEAR_BY] = self.dt * self.horizon - (reward.safe_gap + v.length + road.stop_zone) / WALKING_PACE
        c[layout.SIGMA_1 : layout.SIGMA_4 + 1] = reward.sigma_1, reward.sigma_2, reward.sigma_3, reward.sigma_4
        c[[layout.JERK_THRESHOLD, layout.POSITIVE_JERK_ONLY]] = reward.jerk_threshold, reward.positive_jerk_only
        c[[layout.SAFE_GAP, layout.NOMINAL_DECEL, layout.TIMEOUT_SCALE]] = (
            reward.safe_gap,
            v.max_decel,
            reward.timeout_scale,
        )
        c[[layout.START_LOW, layout.START_HIGH]] = road.start_distance
        c[[layout.START_SPEED_LOW, layout.START_SPEED_HIGH]] = road.start_speed
        c[[layout.GAP_LOW, layout.GAP_HIGH]] = traffic.gap
        c[[layout.FRONT_SPEED_LOW, layout.FRONT_SPEED_HIGH]] = traffic.speed
        return c

    def family_table(self) -> NDArray[np.float64]:
        """Return the profile families as the kernels' packed array."""
        return family_table(self.traffic.families)

    def cumulative_counts(self) -> NDArray[np.float64]:
        """Return the cumulative shares of 0, 1, 2, ... front vehicles, float64 [max_fronts + 1]."""
        shares = np.cumsum(self.traffic.count_shares)
        shares[-1] = 1.0
        return shares


def _digest(data: object) -> str:
    return hashlib.sha256(json.dumps(data, sort_keys=True, allow_nan=False).encode()).hexdigest()
