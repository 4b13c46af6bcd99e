"""Drawing the world of one episode, and whether any ego could succeed in it.

Every number of a world is a pure function of (seed, episode, attempt, vehicle, purpose); an attempt follows another
only where the scenario keeps feasible worlds alone.
"""

from math import sqrt

import numpy as np

from hhrl_envs import layout
from hhrl_envs.compiled import Floats, kernel
from hhrl_envs.dynamics import drive_ego
from hhrl_envs.layout import APPROACHING, FAR, LEAVING
from hhrl_envs.streams import between, stream, unit
from hhrl_envs.traffic import HARDEST_DECEL, drive_traffic, needed_decel

COUNT, START, PROFILE = range(3)  # purposes of the streams
STYLE_DRAW, SLOW_DRAW, FAMILY_DRAW = 100, 101, 102  # draw indices beside those of the parameters
PARAMETERS = layout.SLOW_TIME + 1
FULL, ROLLING, RUNS = range(3)
NEVER = -1.0e5  # m; a place before the line that no vehicle passes
EASY_DECEL = 3.0  # m/s^2; initial speeds leave every follower this comfortable a stop
SHORT_HEADWAY = 1.0  # s; initial speeds above the leader's leave every follower this much time
MAX_ATTEMPTS = 1000


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
        profile[layout.SLOW_AT, k, i] = NEVER
    draw = unit(key, STYLE_DRAW)
    style = FULL if draw < families[family, -3] else (ROLLING if draw < families[family, -2] else RUNS)
    if style == FULL:
        profile[layout.LINE_SPEED, k, i] = 0.0
    else:
        profile[layout.STOP_POSITION, k, i] = 0.0
    profile[layout.STYLE, k, i] = style
    profile[layout.FAMILY, k, i] = family


@kernel
def clear_slot(state: Floats, profile: Floats, k: int, i: int) -> None:
    """Send slot ``k`` of row ``i`` far down the road, where it drives on without meeting anyone."""
    state[:, k, i] = 0.0
    state[layout.POSITION, k, i] = FAR * k
    state[layout.PHASE, k, i] = LEAVING
    profile[:, k, i] = 1.0
    profile[layout.SLOW_AT, k, i] = NEVER


@kernel
def place_vehicles(state: Floats, fronts: int, i: int, seed: np.uint64, episode: np.uint64, c: Floats) -> None:
    """Draw positions and speeds, the ego first; a speed is bounded so that nobody starts in an emergency."""
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
def first_phase(x: float, v: float, style: float, v_line: float, stop_position: float) -> float:
    """Return the phase in which a vehicle starts: leaving if it runs the line, is past it or cannot stop any more."""
    to_stop = -stop_position - x
    late = (to_stop <= 0.0) | (needed_decel(v, v_line, to_stop) > 0.8 * HARDEST_DECEL)
    return LEAVING if late | (style == RUNS) else APPROACHING


@kernel
def draw_world(
    state: Floats,
    profile: Floats,
    i: int,
    seed: np.uint64,
    episode: np.uint64,
    c: Floats,
    counts: Floats,
    families: Floats,
) -> int:
    """Draw the world of row ``i`` and return its number of front vehicles."""
    slots = state.shape[1]
    draw = unit(stream(seed, episode, 0, COUNT), 0)
    fronts = 0
    while draw >= counts[fronts]:
        fronts += 1
    for k in range(slots):
        clear_slot(state, profile, k, i)
    place_vehicles(state, fronts, i, seed, episode, c)
    for k in range(1, fronts + 1):
        draw_profile(profile, k, i, stream(seed, episode, k, PROFILE), families)
        state[layout.PHASE, k, i] = first_phase(
            state[layout.POSITION, k, i], state[layout.SPEED, k, i], profile[layout.STYLE, k, i],
            profile[layout.LINE_SPEED, k, i], profile[layout.STOP_POSITION, k, i],
        )  # fmt: skip
    return fronts


@kernel
def is_feasible(state: Floats, profile: Floats, i: int, c: Floats) -> bool:
    """Return whether some ego can succeed in row ``i``, which stands at its start.

    Scripted vehicles never react to the ego behind them, so full braking minimises the ego's position at every time:
    if it collides, the collision is unavoidable. Success also needs the front vehicles to leave the line early
    enough to cover the last metres of the queue at walking pace before the time limit.
    """
    world, drivers = state[:, :, i : i + 1].copy(), profile[:, :, i : i + 1].copy()
    brake = np.full(1, c[layout.EGO_MIN_ACCEL])
    for step in range(int(c[layout.HORIZON])):
        rear = world[layout.POSITION, 1, 0] - c[layout.LENGTH]
        if rear <= world[layout.POSITION, 0, 0]:
            return False
        if (rear > 0.0) & (world[layout.SPEED, 0, 0] == 0.0):
            return bool(step * c[layout.DT] <= c[layout.CLEAR_BY])
        drive_traffic(world, drivers, c, 1)
        drive_ego(world, brake, c, 1)
    return False


@kernel
def begin(
    state: Floats, profile: Floats, i: int, seed: np.uint64, episode: np.uint64, feasible_only: bool,
    c: Floats, counts: Floats, families: Floats,
) -> bool:  # fmt: skip
    """Put row ``i`` at the start of its episode and return whether the episode is feasible.

    With ``feasible_only`` worlds are drawn anew, each attempt from streams of its own, until one is.
    """
    for attempt in range(MAX_ATTEMPTS):
        key = stream(seed, episode, attempt, 0)
        draw_world(state, profile, i, key, episode, c, counts, families)
        feasible = is_feasible(state, profile, i, c)
        if feasible or not feasible_only:
            return feasible
    return False
