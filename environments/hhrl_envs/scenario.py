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

from hhrl_envs import layout, observation
from hhrl_envs.compiled import Floats
from hhrl_envs.errors import require_value
from hhrl_envs.goals import Goal
from hhrl_envs.options import Option
from hhrl_envs.profiles import ProfileFamily, Range, family_table

GRAVITY = 9.81  # m/s^2
WALKING_PACE = 1.4  # m/s; the speed at which a feasible episode leaves time to reach the freed stop zone


def _require_range(name: str, value: Range, low: float, high: float = inf) -> None:
    require_value(low <= value[0] <= value[1] <= high, name, value, f"(low, high) with {low} <= low <= high <= {high}")


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
        require_value(
            len(self.levels) >= 2 and list(self.levels) == sorted(set(self.levels)),
            "levels",
            self.levels,
            "at least two accelerations, ascending",
        )
        require_value(
            self.levels[0] < 0.0 < self.levels[-1],
            "levels",
            self.levels,
            "levels from a brake below 0 to a throttle above 0",
        )
        require_value(0.0 <= self.lag < inf, "lag", self.lag, "seconds, 0 or more")
        require_value(0.0 < self.jerk_limit < inf, "jerk_limit", self.jerk_limit, "m/s^3 above 0")
        require_value(0.0 < self.max_decel < inf, "max_decel", self.max_decel, "m/s^2 above 0")
        require_value(0.0 < self.length < inf, "length", self.length, "metres above 0")


@dataclass(frozen=True)
class Road:
    """The approach: speed limit, stop-lines, stop window ``0 <= d_d <= stop_zone`` at ``v_e < stop_speed``, start.

    ``lines`` are the positions of none, one or two stop-lines; the ego starts ``start_distance`` metres before
    position 0. ``friction`` times 9.81 m/s^2 is the most that any vehicle brakes or accelerates with.
    """

    speed_limit: float = 12.0
    lines: tuple[float, ...] = (0.0,)
    stop_zone: float = 2.0
    stop_speed: float = 0.1
    friction: float = 1.0
    start_distance: Range = (55.0, 85.0)
    start_speed: Range = (5.0, 10.0)

    def __post_init__(self) -> None:
        """Reject values without a meaning."""
        require_value(0.0 < self.speed_limit < inf, "speed_limit", self.speed_limit, "m/s above 0")
        require_value(len(self.lines) <= 2, "lines", self.lines, "the positions of none, one or two stop-lines")
        require_value(
            all(0.0 <= line <= 500.0 for line in self.lines), "lines", self.lines, "positions within [0, 500]"
        )
        require_value(list(self.lines) == sorted(set(self.lines)), "lines", self.lines, "positions in ascending order")
        require_value(0.0 < self.stop_zone < inf, "stop_zone", self.stop_zone, "metres above 0")
        require_value(0.0 < self.stop_speed < inf, "stop_speed", self.stop_speed, "m/s above 0")
        require_value(0.0 < self.friction <= 1.5, "friction", self.friction, "a coefficient in (0, 1.5]")
        _require_range("start_distance", self.start_distance, self.stop_zone, 500.0)
        _require_range("start_speed", self.start_speed, 0.0, self.speed_limit)


@dataclass(frozen=True)
class Signal:
    """A traffic light at the only line: red until a time drawn from ``green_at`` seconds, green ever after."""

    green_at: Range

    def __post_init__(self) -> None:
        """Reject values without a meaning."""
        _require_range("green_at", self.green_at, 0.0)


@dataclass(frozen=True)
class Band:
    """What following means: a gap from ``low`` to ``high + headway * v_f`` metres in a ``share`` of all steps.

    A vehicle that stands still while its leader drives on leaves the band.
    """

    low: float = 2.0
    high: float = 10.0
    headway: float = 3.0
    share: float = 0.8

    def __post_init__(self) -> None:
        """Reject values without a meaning."""
        require_value(
            0.0 <= self.low < self.high < inf, "low, high", (self.low, self.high), "metres with 0 <= low < high"
        )
        require_value(0.0 <= self.headway < inf, "headway", self.headway, "seconds, 0 or more")
        require_value(0.0 < self.share <= 1.0, "share", self.share, "a share in (0, 1]")


@dataclass(frozen=True)
class Sensor:
    """What the agents' sensors do: ranges, normal noise on the base quantities (standard deviations), delay in steps.

    Safety distances are computed from the noisy quantities; rewards and outcomes use the truth.
    """

    front_range: float = 100.0
    line_range: float = 100.0
    noise_distance: float = 0.0
    noise_speed: float = 0.0
    noise_accel: float = 0.0
    delay: int = 0

    def __post_init__(self) -> None:
        """Reject values without a meaning."""
        for name in ("front_range", "line_range"):
            require_value(0.0 < getattr(self, name) <= 1000.0, name, getattr(self, name), "metres in (0, 1000]")
        for name in ("noise_distance", "noise_speed", "noise_accel"):
            require_value(
                0.0 <= getattr(self, name) < inf, name, getattr(self, name), "a standard deviation, 0 or more"
            )
        require_value(0 <= self.delay <= 50, "delay", self.delay, "steps, 0 to 50")

    @property
    def perfect(self) -> bool:
        """Whether the agents see the truth."""
        return self.delay == 0 and self.noise_distance == self.noise_speed == self.noise_accel == 0.0


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
        require_value(
            min(self.count_shares, default=-1.0) >= 0.0 and abs(total - 1.0) < 1e-9,
            "count_shares",
            self.count_shares,
            "shares of 0, 1, 2, ... front vehicles that add up to 1",
        )
        require_value(len(self.families) > 0, "families", self.families, "at least one profile family")
        _require_range("gap", self.gap, 1.0)
        _require_range("speed", self.speed, 0.0)

    @property
    def max_fronts(self) -> int:
        """The largest number of front vehicles that can be drawn."""
        return max(count for count, share in enumerate(self.count_shares) if share > 0.0)


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
            require_value(0.0 <= getattr(self, name) < inf, name, getattr(self, name), "a number, 0 or more")
        require_value(0.0 < self.safe_gap < inf, "safe_gap", self.safe_gap, "metres above 0")


@dataclass(frozen=True)
class Adversary:
    """The limits of a front vehicle that is trained to make the ego fail: what a human driver might do.

    It brakes with at most ``hardest_brake``, an emergency stop on a dry road being about 8 m/s^2 and a hard stop in
    traffic 4 to 5 m/s^2. It has ``patience`` seconds of standing still in all; once they are used up it drives on.
    Its actuator, lag and jerk limit are those of every agent.
    """

    hardest_brake: float = 4.5
    patience: float = 8.0

    def __post_init__(self) -> None:
        """Reject values without a meaning."""
        require_value(0.0 < self.hardest_brake < inf, "hardest_brake", self.hardest_brake, "m/s^2 above 0")
        require_value(0.0 <= self.patience < inf, "patience", self.patience, "seconds, 0 or more")


@dataclass(frozen=True)
class Scenario:
    """A world with a versioned id. ``feasible_only`` rejects, at reset, worlds in which no ego could succeed.

    The ``goal`` says what SUCCESS is: STOP at the last line, PASS ``route_end`` metres beyond position 0, or FOLLOW
    within the ``band`` until the horizon. ``learned_fronts`` is how many front vehicles are agents too where a view has
    several agents and is not told otherwise; the nearest of them is the ``adversary`` if there is one.
    """

    id: str
    traffic: Traffic
    vehicle: Vehicle = Vehicle()
    road: Road = Road()
    sensor: Sensor = Sensor()
    reward: Reward = Reward()
    goal: Goal = Goal.STOP
    signal: Signal | None = None
    route_end: float = 40.0
    band: Band = Band()
    dt: float = 0.1
    horizon: int = 600
    feasible_only: bool = True
    learned_fronts: int | None = None
    adversary: Adversary | None = None

    def __post_init__(self) -> None:
        """Reject values without a meaning or that contradict each other."""
        require_value(0.0 < self.dt <= 1.0, "dt", self.dt, "seconds in (0, 1]")
        require_value(self.horizon >= 1, "horizon", self.horizon, "a number of steps, at least 1")
        require_value(0.0 < self.route_end < inf, "route_end", self.route_end, "metres above 0")
        lines, goal = self.road.lines, self.goal
        require_value(goal != Goal.STOP or len(lines) > 0, "lines", lines, "at least one line for goal STOP")
        require_value(goal != Goal.FOLLOW or len(lines) == 0, "lines", lines, "no line for goal FOLLOW")
        require_value(
            goal != Goal.FOLLOW or self.traffic.count_shares[0] == 0.0,
            "count_shares",
            self.traffic.count_shares,
            "a first share of 0 for goal FOLLOW: there must be somebody to follow",
        )
        require_value(
            self.signal is None or (goal == Goal.PASS and len(lines) == 1),
            "signal",
            self.signal,
            "None, or goal PASS with one line",
        )
        self.require_fronts(self.learned_fronts or 0)
        require_value(
            self.adversary is None or (self.learned_fronts == 1 and goal == Goal.STOP and len(lines) == 1),
            "adversary",
            self.adversary,
            "None, or learned_fronts=1, goal STOP and one line",
        )

    def require_fronts(self, learned: int) -> None:
        """Return nothing; raises ``InputError`` if the scenario cannot have that many learned front vehicles."""
        most = 0 if self.goal == Goal.FOLLOW else self.traffic.max_fronts
        require_value(0 <= learned <= most, "learned_fronts", learned, f"0 to {most} for scenario {self.id!r}")

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
        """Which of the global options exist here: SSL where there is a line, FFV where there is traffic."""
        return (len(self.road.lines) > 0, self.traffic.max_fronts > 0)

    @property
    def plain(self) -> bool:
        """Whether the world is nothing but a road with one line to stop at."""
        return self.goal == Goal.STOP and len(self.road.lines) == 1 and self.signal is None

    @property
    def spec_hash(self) -> str:
        """The SHA-256 of the scenario's data: equal hashes mean equal worlds. A part that is None does not count."""
        return _digest({part: value for part, value in asdict(self).items() if value is not None})

    @property
    def interface_hash(self) -> str:
        """The SHA-256 of what an agent sees and answers: observation, option and action sets."""
        sets = {
            "observation": [observation.SYMBOLS, observation.SCALES.tolist()],
            "options": [option.name for option in Option],
            "levels": self.vehicle.levels,
        }
        return _digest(sets)

    def constants(self, agents: int = 1) -> Floats:
        """Return the scenario's numbers, with so many agents, as the kernels' array, float64 [CONSTANTS_SIZE]."""
        c = np.zeros(layout.CONSTANTS_SIZE)
        for place, value in self._numbers().items():
            c[place] = value
        c[layout.FEASIBLE_ONLY], c[layout.SLOTS], c[layout.AGENTS] = self.feasible_only, self.num_vehicles + 1, agents
        c[layout.ADVERSARY] = self.adversary is not None and agents > 1
        return c

    def _numbers(self) -> dict[int, float]:
        return {**self._physics(), **self._judgement(), **self._draws(), **self._perception()}

    def _physics(self) -> dict[int, float]:
        vehicle, lines = self.vehicle, self.road.lines
        return {
            layout.DT: self.dt,
            layout.PER_DT: 1.0 / self.dt,
            layout.HORIZON: self.horizon,
            layout.LENGTH: vehicle.length,
            layout.LAG_GAIN: self.dt / (vehicle.lag + self.dt),
            layout.JERK_STEP: vehicle.jerk_limit * self.dt,
            layout.EGO_MIN_ACCEL: vehicle.levels[0],
            layout.GRIP: self.road.friction * GRAVITY,
            layout.SPEED_LIMIT: self.road.speed_limit,
            layout.FIRST_LINE: lines[0] if lines else layout.FAR,
            layout.LAST_LINE: lines[-1] if lines else layout.FAR,
        }

    def _judgement(self) -> dict[int, float]:
        reward, road, band, adversary = self.reward, self.road, self.band, self.adversary or Adversary()
        queue = reward.safe_gap + self.vehicle.length + road.stop_zone
        return {
            layout.STOP_ZONE: road.stop_zone,
            layout.STOP_SPEED: road.stop_speed,
            layout.GOAL: self.goal,
            layout.ROUTE_END: self.route_end,
            layout.CLEAR_BY: self.dt * self.horizon - queue / WALKING_PACE,
            layout.SIGMA_1: reward.sigma_1,
            layout.SIGMA_2: reward.sigma_2,
            layout.SIGMA_3: reward.sigma_3,
            layout.SIGMA_4: reward.sigma_4,
            layout.JERK_THRESHOLD: reward.jerk_threshold,
            layout.POSITIVE_JERK_ONLY: reward.positive_jerk_only,
            layout.SAFE_GAP: reward.safe_gap,
            layout.PER_TWICE_DECEL: 1.0 / (2.0 * self.vehicle.max_decel),
            layout.TIMEOUT_SCALE: reward.timeout_scale,
            layout.BAND_LOW: band.low,
            layout.BAND_HIGH: band.high,
            layout.BAND_HEADWAY: band.headway,
            layout.BAND_SHARE: band.share,
            layout.HARDEST_BRAKE: adversary.hardest_brake,
            layout.PATIENCE: adversary.patience,
            layout.THROTTLE: self.vehicle.levels[-1],
        }

    def _draws(self) -> dict[int, float]:
        road, traffic = self.road, self.traffic
        green = self.signal.green_at if self.signal else (layout.FAR, layout.FAR)
        ranges = {
            layout.START_LOW: road.start_distance,
            layout.START_SPEED_LOW: road.start_speed,
            layout.GAP_LOW: traffic.gap,
            layout.FRONT_SPEED_LOW: traffic.speed,
            layout.GREEN_LOW: green,
        }
        numbers = {place + end: drawn[end] for place, drawn in ranges.items() for end in (0, 1)}
        return {**numbers, layout.SIGNAL: self.signal is not None}

    def _perception(self) -> dict[int, float]:
        sensor = self.sensor
        return {
            layout.FRONT_RANGE: sensor.front_range,
            layout.LINE_RANGE: sensor.line_range,
            layout.NOISE_SPEED: sensor.noise_speed,
            layout.NOISE_ACCEL: sensor.noise_accel,
            layout.NOISE_DISTANCE: sensor.noise_distance,
        }

    def family_table(self) -> Floats:
        """Return the profile families as the kernels' packed array."""
        return family_table(self.traffic.families)

    def cumulative_counts(self) -> Floats:
        """Return the cumulative shares of 0, 1, 2, ... front vehicles, float64 [max_fronts + 1]."""
        shares = np.cumsum(self.traffic.count_shares[: self.traffic.max_fronts + 1])
        shares[-1] = 1.0
        return shares


def _digest(data: object) -> str:
    return hashlib.sha256(json.dumps(data, sort_keys=True, allow_nan=False).encode()).hexdigest()
