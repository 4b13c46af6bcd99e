"""Drawing the world of one episode.

Every number of a world is a pure function of (seed, episode, attempt, vehicle, purpose); an attempt follows another
only where the scenario keeps feasible worlds alone.
"""

from math import sqrt

import numpy as np

from hhrl_envs import layout
from hhrl_envs.compiled import Floats, kernel
from hhrl_envs.layout import APPROACHING, FAR
from hhrl_envs.streams import between, stream, unit
from hhrl_envs.traffic import HARDEST_DECEL, needed_decel

COUNT, START, PROFILE, GREEN = range(4)  # purposes of the streams
STYLE_DRAW, SLOW_DRAW, FAMILY_DRAW = 100, 101, 102  # draw indices beside those of the parameters
PARAMETERS = layout.SLOW_EVERY + 1
FULL, ROLLING, RUNS = range(3)
EASY_DECEL = 3.0  # m/s^2; initial speeds leave every follower this comfortable a stop
SHORT_HEADWAY = 1.0  # s; initial speeds above the leader's leave every follower this much time


@kernel
def draw_profile(profile: Floats, k: int, i: int, key: np.uint64, families: Floats) -> None:
    """Draw the behaviour profile of slot ``k`` in row ``i``."""
    choice = unit(key, FAMILY_DRAW)
    family = 0
    while choice >= families[family, -5]:
        family += 1
    for p in range(PARAMETERS):
        profile[p, k, i] = between(key, p, families[family, 2 * p], families[family, 2 * p + 1])
    if unit(key, SLOW_DRAW) >= families[family, -4]:
        profile[layout.SLOW_AT, k, i] = -FAR
    draw = unit(key, STYLE_DRAW)
    style = FULL if draw < families[family, -3] else (ROLLING if draw < families[family, -2] else RUNS)
    if style == FULL:
        profile[layout.LINE_SPEED, k, i] = 0.0
    else:
        profile[layout.STOP_POSITION, k, i] = 0.0
    profile[layout.STYLE, k, i] = style
    profile[layout.FAMILY, k, i] = family
    profile[layout.PER_DESIRED_SPEED, k, i] = 1.0 / profile[layout.DESIRED_SPEED, k, i]
    squared = profile[layout.MAX_ACCEL, k, i] * profile[layout.COMFORT_DECEL, k, i]
    profile[layout.INTERACTION, k, i] = 1.0 / (2.0 * sqrt(squared))


@kernel
def clear_slot(state: Floats, profile: Floats, k: int, i: int) -> None:
    """Send slot ``k`` of row ``i`` far down the road, where it drives on without meeting anyone or anything."""
    for field in range(layout.STATE_SIZE):
        state[field, k, i] = 0.0
    for field in range(layout.PROFILE_SIZE):
        profile[field, k, i] = 1.0
    state[layout.POSITION, k, i] = FAR * (k + 1)
    state[layout.LINE, k, i] = FAR * FAR
    state[layout.NEXT_SLOW, k, i] = FAR * FAR


@kernel
def place_vehicles(state: Floats, fronts: int, i: int, seed: np.uint64, episode: np.uint64, c: Floats) -> None:
    """Draw positions and speeds, the ego first; a speed is bounded so that no front vehicle starts in an emergency."""
    for k in range(fronts + 1):
        key = stream(seed, episode, k, START)
        ahead = c[layout.LENGTH] + between(key, 0, c[layout.GAP_LOW], c[layout.GAP_HIGH])
        start = -between(key, 0, c[layout.START_LOW], c[layout.START_HIGH])
        state[layout.POSITION, k, i] = start if k == 0 else state[layout.POSITION, k - 1, i] + ahead
        low = c[layout.START_SPEED_LOW] if k == 0 else c[layout.FRONT_SPEED_LOW]
        high = c[layout.START_SPEED_HIGH] if k == 0 else c[layout.FRONT_SPEED_HIGH]
        state[layout.SPEED, k, i] = between(key, 1, low, high)
    for k in range(fronts - 1, 0, -1):
        gap = state[layout.POSITION, k + 1, i] - c[layout.LENGTH] - state[layout.POSITION, k, i]
        leader = state[layout.SPEED, k + 1, i]
        bound = min(sqrt(leader * leader + 2.0 * EASY_DECEL * gap), max(leader, gap / SHORT_HEADWAY))
        state[layout.SPEED, k, i] = min(state[layout.SPEED, k, i], bound)


@kernel
def first_line(x: float, v: float, style: float, v_line: float, stop_position: float, c: Floats) -> float:
    """Return the position of the line that a front vehicle heads for: the first at which it can and wants to stop."""
    if style == RUNS:
        return FAR
    for line in (c[layout.FIRST_LINE], c[layout.LAST_LINE]):
        to_stop = line - stop_position - x
        if (to_stop > 0.0) & (needed_decel(v, v_line, to_stop) <= 0.8 * HARDEST_DECEL):
            return float(line)
    return FAR


@kernel
def settle(state: Floats, profile: Floats, k: int, i: int, c: Floats) -> None:
    """Put the front vehicle in slot ``k`` of row ``i`` into the state that its profile starts in."""
    x = state[layout.POSITION, k, i]
    state[layout.PHASE, k, i] = APPROACHING
    state[layout.LINE, k, i] = first_line(
        x, state[layout.SPEED, k, i], profile[layout.STYLE, k, i], profile[layout.LINE_SPEED, k, i],
        profile[layout.STOP_POSITION, k, i], c,
    )  # fmt: skip
    place = -profile[layout.SLOW_AT, k, i]
    while place < x:
        place += profile[layout.SLOW_EVERY, k, i]
    state[layout.NEXT_SLOW, k, i] = place
    if c[layout.SIGNAL] != 0.0:
        profile[layout.DWELL, k, i] = FAR


@kernel
def draw_world(
    state: Floats, profile: Floats, rows: Floats, i: int, seed: np.uint64, episode: np.uint64,
    c: Floats, counts: Floats, families: Floats,
) -> int:  # fmt: skip
    """Draw the world of row ``i`` and return its number of front vehicles."""
    draw = unit(stream(seed, episode, 0, COUNT), 0)
    fronts = 0
    while draw >= counts[fronts]:
        fronts += 1
    for k in range(state.shape[1]):
        clear_slot(state, profile, k, i)
    place_vehicles(state, fronts, i, seed, episode, c)
    state[layout.LINE, 0, i] = c[layout.FIRST_LINE]
    for k in range(1, fronts + 1):
        draw_profile(profile, k, i, stream(seed, episode, k, PROFILE), families)
        settle(state, profile, k, i, c)
    rows[layout.GREEN_AT, i] = between(stream(seed, episode, 0, GREEN), 0, c[layout.GREEN_LOW], c[layout.GREEN_HIGH])
    rows[layout.KEPT, i] = 0.0
    return fronts
