"""Drawing the world of one episode.

Every number of a world is a pure function of (seed, episode, attempt, vehicle, purpose); an attempt follows another
only where the scenario keeps feasible worlds alone.
"""

from math import floor, sqrt

import numpy as np

from hhrl_envs.arrays import Floats
from hhrl_envs.scenario.scenario import GRAVITY, Scenario
from hhrl_envs.simulation.engine import layout as at
from hhrl_envs.simulation.engine.compilation import inner, unsigned
from hhrl_envs.simulation.engine.layout import (
    APPROACHING,
    FAMILY_TABLE_WIDTH,
    FAR,
    RANGES,
    SLOW_CHANCE,
    STYLE_SHARES,
    WEIGHT,
)
from hhrl_envs.simulation.engine.random_streams import between, stream, unit
from hhrl_envs.simulation.traffic import (
    HARDEST_DECEL,
    STANDSTILL,
    fastest_front,
    guard_margin,
    hardest_decel,
    needed_decel,
)

EGO = unsigned(0)
COUNT, START, PROFILE, GREEN, FRICTION = (unsigned(purpose) for purpose in range(5))  # of the streams
FIRST, SECOND = unsigned(0), unsigned(1)  # draw indices
STYLE_DRAW, SLOW_DRAW, FAMILY_DRAW = unsigned(100), unsigned(101), unsigned(102)  # beside those of the parameters
# Among the fields of a vehicle's record: those of its motion that a world always clears, and those of its profile.
MOVING, MOVED, PROFILED, DRAWN = (int(end) // at.STRIDE for end in (at.ACCEL, at.NEXT_SLOW, at.PROFILE, at.TARGET))
FULL, ROLLING, RUNS = range(3)
NOBODYS = -1.0  # the FAMILY of absent vehicles
EASY_DECEL = 3.0  # m/s^2; initial speeds leave every follower this comfortable a stop
COUNTED = 100.0  # slow-downs behind a vehicle's start that are counted off one by one
SHORT_HEADWAY = 1.0  # s; initial speeds above the leader's leave every follower this much time


def abruptest_stop(scenario: Scenario) -> float:
    """Return a deceleration that no scripted vehicle exceeds, in m/s^2.

    One that creeps stands at once. Where the road is slippery or a step long, one may start too near to its leader for
    its brakes; the bound on its speed makes up for that in the first step.
    """
    hardest, gap = hardest_decel(scenario), scenario.traffic.gap[0]
    weakest = min(hardest, scenario.road.frictions[0] * GRAVITY)
    safe = EASY_DECEL * gap <= weakest * (gap - guard_margin(scenario))
    return hardest + 2.0 * STANDSTILL / scenario.dt if safe else fastest_front(scenario) / scenario.dt


@inner
def draw_profile(m: Floats, s: int, key: np.uint64, c: Floats) -> None:
    """Draw the behaviour profile of the vehicle ``s``, a record plus a lane."""
    choice = unit(key, FAMILY_DRAW)
    family, table = 0, at.COUNTS + int(c[at.SLOTS]) - 1
    while choice >= c[table + WEIGHT]:
        family, table = family + 1, table + FAMILY_TABLE_WIDTH
    for p in range(RANGES):
        drawn = between(key, unsigned(p), c[table + 2 * p], c[table + 2 * p + 1])
        m[s + at.PROFILE + unsigned(p * at.STRIDE)] = drawn
    if unit(key, SLOW_DRAW) >= c[table + SLOW_CHANCE]:
        m[s + at.SLOW_AT] = -FAR
    draw = unit(key, STYLE_DRAW)
    style = FULL if draw < c[table + STYLE_SHARES] else (ROLLING if draw < c[table + STYLE_SHARES + 1] else RUNS)
    m[s + (at.LINE_SPEED if style == FULL else at.STOP_POSITION)] = 0.0
    m[s + at.STYLE] = style
    m[s + at.FAMILY] = family
    m[s + at.PER_DESIRED_SPEED] = 1.0 / m[s + at.DESIRED_SPEED]
    m[s + at.INTERACTION] = 1.0 / (2.0 * sqrt(m[s + at.MAX_ACCEL] * m[s + at.COMFORT_DECEL]))


@inner
def clear_state(m: Floats, s: int) -> None:
    """Forget how the vehicle ``s`` was moving; its place, speed and profile are drawn."""
    for field in range(MOVING, MOVED):
        m[s + unsigned(field * at.STRIDE)] = 0.0


@inner
def send_away(m: Floats, s: int, slot: int) -> None:
    """Send the vehicle ``s`` far down the road, where it drives on without meeting anyone or anything.

    Its profile is all ones but for the FAMILY, which says that it is nobody's.
    """
    if m[s + at.FAMILY] != NOBODYS:
        for field in range(PROFILED, DRAWN):
            m[s + unsigned(field * at.STRIDE)] = 1.0
        m[s + at.FAMILY] = NOBODYS
    m[s + at.POSITION] = FAR * (slot + 1)
    m[s + at.SPEED] = 0.0
    m[s + at.LINE] = FAR * FAR
    m[s + at.NEXT_SLOW] = FAR * FAR


@inner
def place_vehicles(
    m: Floats, s: int, fronts: int, world: np.uint64, episode: np.uint64, c: Floats, special: bool | None
) -> None:
    """Draw positions and speeds, the ego first; a speed is bounded so that no front vehicle starts in an emergency."""
    for k in range(fronts + 1):
        key, here = stream(world, episode, unsigned(k), START), s + unsigned(k) * at.VEHICLE
        ahead = c[at.LENGTH] + between(key, FIRST, c[at.GAP_LOW], c[at.GAP_HIGH])
        start = -between(key, FIRST, c[at.START_LOW], c[at.START_HIGH])
        m[here + at.POSITION] = start if k == 0 else m[here - at.VEHICLE + at.POSITION] + ahead
        low = c[at.START_SPEED_LOW] if k == 0 else c[at.FRONT_SPEED_LOW]
        high = c[at.START_SPEED_HIGH] if k == 0 else c[at.FRONT_SPEED_HIGH]
        m[here + at.SPEED] = between(key, SECOND, low, high)
    if special is not None:
        move_back(m, s, fronts, c)
    for k in range(fronts - 1, 0, -1):
        here = s + unsigned(k) * at.VEHICLE
        gap = m[here + at.VEHICLE + at.POSITION] - c[at.LENGTH] - m[here + at.POSITION]
        leader = m[here + at.VEHICLE + at.SPEED]
        bound = min(sqrt(leader * leader + 2.0 * EASY_DECEL * gap), max(leader, gap / SHORT_HEADWAY))
        m[here + at.SPEED] = min(m[here + at.SPEED], bound)


@inner
def move_back(m: Floats, s: int, fronts: int, c: Floats) -> None:
    """Move all vehicles back by as much as the foremost agent stands ahead of the ego.

    So it is the foremost agent that starts where an ego alone would, and all agents have the whole approach to drive.
    """
    back = m[s + unsigned(c[at.AGENTS] - 1.0) * at.VEHICLE + at.POSITION] - m[s + at.POSITION]
    if back > 0.0:
        for k in range(unsigned(fronts + 1)):
            m[s + k * at.VEHICLE + at.POSITION] -= back


@inner
def first_line(m: Floats, s: int, c: Floats) -> float:
    """Return the position of the line that the vehicle ``s`` heads for: the first at which it can and wants to stop."""
    if m[s + at.STYLE] == RUNS:
        return FAR
    line = c[at.FIRST_LINE]
    while line < FAR:
        to_stop = line - m[s + at.STOP_POSITION] - m[s + at.POSITION]
        needed = needed_decel(m[s + at.SPEED], m[s + at.LINE_SPEED], to_stop)
        if (to_stop > 0.0) & (needed <= 0.8 * HARDEST_DECEL):
            return float(line)
        line = c[at.LAST_LINE] if line < c[at.LAST_LINE] else FAR
    return FAR


@inner
def settle(m: Floats, s: int, c: Floats) -> None:
    """Put the front vehicle ``s`` into the state that its profile starts in."""
    m[s + at.PHASE] = APPROACHING
    m[s + at.LINE] = first_line(m, s, c)
    place, every = -m[s + at.SLOW_AT], m[s + at.SLOW_EVERY]
    place += max(floor((m[s + at.POSITION] - place) / every) - COUNTED, 0.0) * every
    while place < m[s + at.POSITION]:
        place += every
    m[s + at.NEXT_SLOW] = place
    if c[at.SIGNAL] != 0.0:
        m[s + at.DWELL] = FAR


@inner
def draw_friction(world: np.uint64, episode: np.uint64, c: Floats) -> float:
    """Draw the road's friction in a world."""
    key = stream(world, episode, EGO, FRICTION)
    drawn = between(key, SECOND, c[at.SLIPPERY_LOW], c[at.SLIPPERY_HIGH])
    return float(drawn if unit(key, FIRST) < c[at.SLIPPERY_SHARE] else c[at.FRICTION])


@inner
def draw_world(m: Floats, s: int, r: int, world: np.uint64, episode: np.uint64, c: Floats, special: bool | None) -> int:
    """Draw the world of one row and return its number of front vehicles.

    ``s`` and ``r`` are the records of its ego and of its block's rows, plus its lane; ``world`` is the key of seed,
    episode and attempt. For ``special`` see ``step.advance_rows``.
    """
    draw, fronts, most = unit(stream(world, episode, EGO, COUNT), FIRST), int(c[at.AGENTS]) - 1, int(c[at.SLOTS]) - 2
    fewer = c[at.COUNTS + fronts - 1] if fronts > 0 else 0.0
    draw = fewer + (1.0 - fewer) * draw if fronts > 0 else draw
    while fronts < most and draw >= c[at.COUNTS + fronts]:
        fronts += 1
    for k in range(int(c[at.SLOTS])):
        here = s + unsigned(k) * at.VEHICLE
        clear_state(m, here)
        if k > fronts:
            send_away(m, here, k)
    place_vehicles(m, s, fronts, world, episode, c, special)
    for k in range(1, fronts + 1):
        here = s + unsigned(k) * at.VEHICLE
        draw_profile(m, here, stream(world, episode, unsigned(k), PROFILE), c)
        settle(m, here, c)
    m[s + at.ROAD_FRICTION] = c[at.FRICTION]
    if special is not None:
        friction = draw_friction(world, episode, c)
        for k in range(unsigned(c[at.SLOTS])):
            m[s + k * at.VEHICLE + at.ROAD_FRICTION] = friction
    for k in range(unsigned(c[at.AGENTS])):
        m[s + k * at.VEHICLE + at.LINE] = c[at.FIRST_LINE]
    m[r + at.GREEN_AT] = between(stream(world, episode, EGO, GREEN), FIRST, c[at.GREEN_LOW], c[at.GREEN_HIGH])
    m[r + at.KEPT] = 0.0
    return fronts
