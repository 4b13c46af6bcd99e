"""Scenarios: worlds as frozen, validated, hashable data.

A scenario says what the road, the ego, the traffic and the reward are; the simulator is the same for all of them.
Lengths are metres, times seconds, speeds m/s, accelerations m/s^2, jerk m/s^3. The stop-line stands at position 0, the
ego starts at a negative position and drives towards it.
"""

from dataclasses import dataclass, field
from enum import IntEnum
from math import ceil
from typing import Literal

from hhrl_envs import observation
from hhrl_envs.errors import InputError
from hhrl_envs.scenario import limits
from hhrl_envs.scenario.hashing import ADDITION, counted, digest
from hhrl_envs.scenario.limits import intervals, numbers
from hhrl_envs.scenario.profiles import ProfileFamily, Range
from hhrl_envs.scenario.sensors import Sensor
from hhrl_envs.scenario.validation import (
    agree,
    ascending,
    check,
    flag,
    instance,
    instances,
    integer,
    is_integer,
    one_of,
    optional,
    shares,
    text,
)
from hhrl_envs.sub_goals import SUB_GOALS

GRAVITY = 9.81  # m/s^2
WALKING_PACE = 1.4  # m/s; the speed at which a feasible episode leaves time to reach the freed stop zone


class Goal(IntEnum):
    """What SUCCESS means: a stop at the last line, reaching the end of the route, or following until the horizon."""

    STOP = 0
    PASS = 1
    FOLLOW = 2


STOP, PASS, FOLLOW = (int(goal) for goal in Goal)


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
        check(
            self,
            levels=ascending(2, 1000, *limits.VEHICLE["levels"][:2], "at least two accelerations in m/s^2"),
            **numbers(limits.VEHICLE, "lag", "jerk_limit", "max_decel", "length"),
        )
        weakest = limits.WEAKEST
        crossing = self.levels[0] <= -weakest and weakest <= self.levels[-1]
        write = f"levels from a brake of {-weakest} or below to a throttle of {weakest} or above"
        agree(self, crossing, "levels", write=write)


@dataclass(frozen=True)
class Slippery:
    """A road that is more slippery in some worlds, or less, and looks the same in all of them.

    In a ``share`` of the worlds the road's friction is drawn from the range ``friction`` instead. In all worlds of such
    a scenario friction also cuts the throttle of scripted vehicles.
    """

    share: float
    friction: Range

    def __post_init__(self) -> None:
        """Reject values without a meaning."""
        check(self, **numbers(limits.SLIPPERY, "share"), **intervals(limits.SLIPPERY, "friction"))


@dataclass(frozen=True)
class Road:
    """The approach: speed limit, stop-lines, stop window ``0 <= d_d <= stop_zone`` at ``v_e < stop_speed``, start.

    ``lines`` are the positions of none, one or two stop-lines; the ego starts ``start_distance`` metres before
    position 0. ``friction`` times 9.81 m/s^2 is the most that any vehicle brakes and any agent accelerates with; no
    observation tells it. It differs from world to world where the road is ``slippery``.
    """

    speed_limit: float = 12.0
    lines: tuple[float, ...] = (0.0,)
    stop_zone: float = 2.0
    stop_speed: float = 0.1
    friction: float = 1.0
    start_distance: Range = (55.0, 85.0)
    start_speed: Range = (5.0, 10.0)
    slippery: Slippery | None = field(default=None, metadata=ADDITION)

    def __post_init__(self) -> None:
        """Reject values without a meaning."""
        check(
            self,
            lines=ascending(0, 2, *limits.ROAD["lines"][:2], "none, one or two stop-lines in metres, such as (0.0,)"),
            **numbers(limits.ROAD, "speed_limit", "stop_zone", "stop_speed", "friction"),
            **intervals(limits.ROAD, "start_distance", "start_speed"),
            slippery=optional(instance(Slippery)),
        )
        before, slow = self.stop_zone <= self.start_distance[0], self.start_speed[1] <= self.speed_limit
        agree(self, before, "start_distance", "stop_zone", write="a start_distance of at least stop_zone")
        agree(self, slow, "start_speed", "speed_limit", write="a start_speed of at most speed_limit")

    @property
    def frictions(self) -> Range:
        """The least and the largest friction that a world may have."""
        low, high = self.slippery.friction if self.slippery else (self.friction, self.friction)
        return min(low, self.friction), max(high, self.friction)


@dataclass(frozen=True)
class Signal:
    """A traffic light at the only line: red until a time drawn from ``green_at`` seconds, green ever after."""

    green_at: Range

    def __post_init__(self) -> None:
        """Reject values without a meaning."""
        check(self, **intervals(limits.SIGNAL, "green_at"))


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
        check(self, **numbers(limits.BAND, "low", "high", "headway", "share"))
        agree(self, self.low < self.high, "low", "high", write="a low below high")


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
        check(
            self,
            families=instances(ProfileFamily),
            count_shares=shares(1, limits.MOST_FRONTS + 1, "the shares of 0, 1, 2, ... front vehicles"),
            **intervals(limits.TRAFFIC, "gap", "speed"),
        )

    @property
    def max_fronts(self) -> int:
        """The largest number of front vehicles that can be drawn."""
        return max(count for count, share in enumerate(self.count_shares) if share > 0.0)


@dataclass(frozen=True)
class Reward:
    """The constants of the paper's reward: sigma_1 time, sigma_2 jerk, sigma_3 collision, sigma_4 success.

    The defaults are those that the paper's Table I implies. ``safe_gap`` is d_0 of Eq. (dis). The paper gives its jerk
    threshold of 1 no unit; here it is in m/s^3. ``timeout_scale`` multiplies the timeout penalty d_d^2 (1 is the
    paper's). ``unsafe`` is how the unsafe terms are read, -exp(x) with x = -d_c / d_s. As printed, x has no bound past
    the line, where d_ds goes to 0 with v_e. "floored" takes d_ds as at least 0.5 m and x as at most 1. "printed" floors
    nothing, and takes x as at most 32 so that nothing overflows.
    """

    sigma_1: float = 0.01
    sigma_2: float = 2.5
    sigma_3: float = 36.0
    sigma_4: float = 49.0
    jerk_threshold: float = 4.0
    positive_jerk_only: bool = False
    safe_gap: float = 5.0
    timeout_scale: float = 0.01
    unsafe: Literal["floored", "printed"] = field(default="floored", metadata=ADDITION)

    def __post_init__(self) -> None:
        """Reject values without a meaning."""
        check(self, **numbers(limits.REWARD, *limits.REWARD), positive_jerk_only=flag())
        check(self, unsafe=one_of("floored", "printed"))


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
        check(self, **numbers(limits.ADVERSARY, "hardest_brake", "patience"))


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
    signal: Signal | None = field(default=None, metadata=ADDITION)
    route_end: float = 40.0
    band: Band = Band()
    dt: float = 0.1
    horizon: int = 600
    feasible_only: bool = True
    learned_fronts: int | None = field(default=None, metadata=ADDITION)
    adversary: Adversary | None = field(default=None, metadata=ADDITION)

    def __post_init__(self) -> None:
        """Reject values without a meaning or that contradict each other."""
        check(
            self,
            id=text(r"[A-Za-z0-9][A-Za-z0-9._-]*", "a name of letters, digits, '-', '_' and '.', such as 'my-road-v0'"),
            traffic=instance(Traffic),
            vehicle=instance(Vehicle),
            road=instance(Road),
            sensor=instance(Sensor),
            reward=instance(Reward),
            goal=instance(Goal),
            signal=optional(instance(Signal)),
            band=instance(Band),
            **numbers(limits.SCENARIO, "route_end", "dt"),
            horizon=integer(*limits.SCENARIO["horizon"]),
            feasible_only=flag(),
            learned_fronts=optional(integer(*limits.SCENARIO["learned_fronts"])),
            adversary=optional(instance(Adversary)),
        )
        self._require_agreement()
        self.require_fronts(self.learned_fronts or 0)
        self._require_time()

    def _require_agreement(self) -> None:
        """Reject parts that contradict the goal or each other."""
        lines, goal = len(self.road.lines), self.goal
        following, single = goal == Goal.FOLLOW, lines == 1
        agree(self, goal != Goal.STOP or lines > 0, "road.lines", "goal", write="at least one line for goal STOP")
        agree(self, not following or lines == 0, "road.lines", "goal", write="no line, lines=(), for goal FOLLOW")
        followed = "a first share of 0 for goal FOLLOW: there must be somebody to follow"
        somebody = self.traffic.count_shares[0] == 0.0
        agree(self, not following or somebody, "traffic.count_shares", "goal", write=followed)
        waits = self.signal is None or (goal == Goal.PASS and single)
        agree(self, waits, "signal", "goal", "road.lines", write="signal None, or goal PASS with one line")
        provoked = self.adversary is None or (self.learned_fronts == 1 and goal == Goal.STOP and single)
        setting = "adversary None, or learned_fronts=1, goal STOP and one line"
        agree(self, provoked, "adversary", "learned_fronts", "goal", "road.lines", write=setting)

    def _require_time(self) -> None:
        """Reject a time limit too long to be simulated, or up before the last metres of a queue could be driven.

        In the latter case no world is feasible.
        """
        most = int(limits.LONGEST / self.dt)
        write = f"a horizon of at most {most} steps, which is {limits.LONGEST:g} s"
        agree(self, self.horizon <= most, "horizon", "dt", write=write)
        enough = self.goal == Goal.FOLLOW or not self.feasible_only or self.clear_by >= 0.0
        seconds = self.dt * self.horizon - self.clear_by
        steps = f"a horizon of {ceil(seconds / self.dt)} steps or more, as a queue takes {seconds:.1f} s to move up"
        agree(self, enough, "horizon", "dt", write=f"{steps}; or feasible_only=False")

    def require_fronts(self, learned: int) -> None:
        """Raise an ``InputError`` if the scenario cannot have that many learned front vehicles."""
        most, allowed = self.traffic.max_fronts, f"for scenario {self.id!r}"
        if self.goal == Goal.FOLLOW or most == 0:
            lack = "goal FOLLOW has no place for learned ones" if most else "its traffic has no front vehicles"
            most, allowed = 0, f"{allowed}: {lack}"
        if not (is_integer(learned) and 0 <= learned <= most):
            write = f"an integer from 0 to {most}" if most else "0"
            raise InputError(f"learned_fronts is {learned!r}; write {write} {allowed}")
        legal = learned == 0 or self.traffic.speed[1] <= self.road.speed_limit
        write = "a traffic.speed of at most the speed_limit, which agents keep to, or learned_fronts 0"
        agree(self, legal, "traffic.speed", "road.speed_limit", write=write)

    @property
    def num_actions(self) -> int:
        """The number of discrete throttle and brake levels."""
        return len(self.vehicle.levels)

    @property
    def num_vehicles(self) -> int:
        """The largest number of vehicles on the road, the ego included."""
        return self.traffic.max_fronts + 1

    @property
    def option_mask(self) -> tuple[bool, ...]:
        """Which of the sub-goals exist here: SSL where there is a line, FFV where there is traffic."""
        return tuple(goal.exists(self) for goal in SUB_GOALS)

    @property
    def plain(self) -> bool:
        """Whether the world is nothing but a road with one line to stop at, and its reward and road are as usual."""
        usual = self.reward.unsafe == "floored" and self.road.slippery is None
        return self.goal == Goal.STOP and len(self.road.lines) == 1 and self.signal is None and usual

    @property
    def spec_hash(self) -> str:
        """The SHA-256 of the scenario's data: equal hashes mean equal worlds. An addition counts where it is used."""
        return digest(counted(self))

    @property
    def interface_hash(self) -> str:
        """The SHA-256 of what an agent sees and answers: observation, option and action sets."""
        sets = {
            "observation": [observation.SYMBOLS, observation.SCALES.tolist()],
            "options": [goal.spelling for goal in SUB_GOALS],
            "levels": self.vehicle.levels,
        }
        return digest(sets)

    @property
    def clear_by(self) -> float:
        """The time in seconds by which the goal's place must be free, so that the last metres can be walked."""
        queue = self.reward.safe_gap + self.vehicle.length + self.road.stop_zone
        return self.dt * self.horizon - queue / WALKING_PACE
