"""Whether any ego could succeed in an episode.

Scripted vehicles never react to the ego behind them, so full braking minimises the ego's position at every time: if it
collides, the collision is unavoidable. Success also needs the nearest front vehicle to leave the goal's place early
enough to cover the last metres of a queue at walking pace before the time limit. Both are decided by driving the world
ahead, unless cheap bounds have decided already. Where the goal is a stop, full braking must also stand before the first
line, and a signal must turn green in time.

Learned front vehicles may react to the ego, so their worlds cannot be driven ahead. There a shadow ego that brakes
fully runs along with the episode, and the verdict is known when the ego's episode ends.
"""

from math import sqrt

from hhrl_envs.arrays import Floats
from hhrl_envs.scenario.scenario import FOLLOW, GRAVITY, STOP
from hhrl_envs.simulation.dynamics import actuate, braking_distance, longest_braking
from hhrl_envs.simulation.engine import layout as at
from hhrl_envs.simulation.engine.compilation import inner, unsigned
from hhrl_envs.simulation.engine.layout import FAR
from hhrl_envs.simulation.traffic import HARDEST_DECEL

SELDOM = 500.0  # m; slow-downs this far apart happen once before the line
SURE_GRIP = 1.5  # m/s^2; on a road with less, whoever closes up to a queue takes longer than `latest_clearing` allows
MARGIN = 0.01  # m; more than rounding takes, or a scripted vehicle that stands as soon as it only creeps


@inner
def bounds_hold(m: Floats, s: int, fronts: int, c: Floats) -> bool:
    """Return whether the road of the ego ``s`` has the grip that the bounds below count on; else they say nothing.

    It must carry every front vehicle's own acceleration, and stop each behind its leader from the start on. The bounds
    hold where a scenario's road is never ``Slippery``.
    """
    if c[at.FREE_THROTTLE] > 0.0:
        return True
    grip = m[s + at.ROAD_FRICTION] * GRAVITY
    hardest, sure = min(HARDEST_DECEL, grip), grip >= SURE_GRIP
    for k in range(1, fronts + 1):
        here = s + unsigned(k) * at.VEHICLE
        leader = here + at.VEHICLE
        room = m[leader + at.POSITION] - c[at.LENGTH] - m[here + at.POSITION] - c[at.GUARD]
        own, ahead = m[here + at.SPEED], m[leader + at.SPEED]
        sure &= (m[here + at.MAX_ACCEL] <= grip) & (own * own <= ahead * ahead + 2.0 * hardest * room)
    return bool(sure)


@inner
def latest_clearing(m: Floats, s: int, fronts: int, c: Floats) -> float:
    """Return a time in seconds by which the front vehicles of the ego ``s`` have surely left the only line behind them.

    Vehicle after vehicle, from the front: to arrive takes at most one and a half times the free drive and two seconds;
    then, once its leader has left, it moves up, dwells and leaves, with a start delay before each and a slow-down.
    """
    free = 0.0
    for k in range(fronts, 0, -1):
        here = s + unsigned(k) * at.VEHICLE
        distance = c[at.LAST_LINE] + c[at.LENGTH] - m[here + at.POSITION]
        arrival = 2.0 + 1.5 * max(distance, 0.0) / m[here + at.DESIRED_SPEED]
        moving_up = 1.0 + 5.0 * sqrt(1.0 / m[here + at.MAX_ACCEL])
        dwell = m[here + at.DWELL] if m[here + at.LINE_SPEED] == 0.0 else 0.0
        slowing = m[here + at.SLOW_TIME] if m[here + at.SLOW_AT] > -FAR else 0.0
        pauses = dwell + 2.0 * m[here + at.START_DELAY] + slowing
        free = max(free, arrival) + moving_up + pauses
    return free


@inner
def surely_clears(m: Floats, s: int, fronts: int, c: Floats) -> bool:
    """Return True where the goal's place is surely free early enough; False says nothing."""
    if c[at.GOAL] == FOLLOW:
        return True
    if (c[at.GOAL] != STOP) | (c[at.FIRST_LINE] != c[at.LAST_LINE]):
        return False
    for k in range(1, fronts + 1):
        if m[s + unsigned(k) * at.VEHICLE + at.SLOW_EVERY] < SELDOM:
            return False
    return bool(latest_clearing(m, s, fronts, c) <= c[at.CLEAR_BY])


@inner
def surely_survives(m: Floats, s: int, c: Floats) -> bool:
    """Return True where full braking stands before the line and behind the front vehicle, brake that as it may.

    False says nothing. Of two vehicles that brake, the front one no less hard, the gap is a concave function of time:
    where they start and where they stand without touching, they never touch. ``last_step`` is more than they can
    be out in the step in which they come to a stand.
    """
    front, grip = s + at.VEHICLE, m[s + at.ROAD_FRICTION] * GRAVITY
    hardest = min(max(HARDEST_DECEL, -c[at.EGO_MIN_ACCEL]), grip)
    rear = m[front + at.POSITION] - c[at.LENGTH] + m[front + at.SPEED] * m[front + at.SPEED] / (2.0 * hardest)
    last_step = hardest * c[at.DT] * c[at.DT]
    room = min(rear - last_step - MARGIN, c[at.FARTHEST]) - m[s + at.POSITION]
    speed = m[s + at.SPEED]
    return bool((longest_braking(speed, grip, c) < room) or (braking_distance(speed, grip, c) < room))


@inner
def is_green(m: Floats, r: int, c: Floats) -> bool:
    """Return whether no red light keeps the row ``r``, a record plus a lane, from the goal."""
    return bool((c[at.SIGNAL] == 0.0) | (m[r + at.STEPS] * c[at.DT] >= m[r + at.GREEN_AT]))


@inner
def verdict(m: Floats, s: int, r: int, c: Floats) -> float:
    """Return 1.0 if the row's episode has proved feasible, 0.0 if infeasible, -1.0 if that is still open.

    The row, of which ``s`` and ``r`` are the records plus its lane, is being driven ahead under full braking.
    """
    ego, rear = m[s + at.POSITION], m[s + at.VEHICLE + at.POSITION] - c[at.LENGTH]
    if (rear <= ego) | (ego > c[at.FARTHEST]) | (m[r + at.STEPS] >= c[at.HORIZON]):
        return 0.0
    if (rear > c[at.GOAL_PLACE]) & (m[s + at.SPEED] == 0.0) & is_green(m, r, c):
        return 1.0 if m[r + at.STEPS] * c[at.DT] <= c[at.CLEAR_BY] else 0.0
    return -1.0


@inner
def start_shadow(m: Floats, s: int, r: int) -> None:
    """Put the shadow of the ego ``s`` to where the ego starts."""
    m[r + at.SHADOW_POSITION], m[r + at.SHADOW_SPEED] = m[s + at.POSITION], m[s + at.SPEED]
    m[r + at.SHADOW_ACCEL], m[r + at.CLEARED] = 0.0, 0.0


@inner
def drive_shadow(m: Floats, s: int, r: int, c: Floats, lanes: int) -> None:
    """Brake the shadow egos by one more step and note FEASIBLE.

    It is 0 once a shadow was hit, or where the goal's place was not freed in time. ``s`` is the egos' record,
    ``r`` that of the rows. The front vehicles have moved. Where they are all scripted there is nothing to be found out.
    """
    if c[at.AGENTS] == 1.0:
        return
    dt, per_dt, brake, place = c[at.DT], c[at.PER_DT], c[at.EGO_MIN_ACCEL], c[at.GOAL_PLACE]
    gain, most = c[at.LAG_GAIN], c[at.JERK_STEP]
    for i in range(lanes):
        grip = m[s + at.ROAD_FRICTION + i] * GRAVITY
        speed, accel = m[r + at.SHADOW_SPEED + i], m[r + at.SHADOW_ACCEL + i]
        moved = max(speed + actuate(accel, brake, gain, most, grip) * dt, 0.0)
        m[r + at.SHADOW_POSITION + i] += 0.5 * (speed + moved) * dt
        m[r + at.SHADOW_SPEED + i], m[r + at.SHADOW_ACCEL + i] = moved, (moved - speed) * per_dt
        rear, time = m[s + at.VEHICLE + at.POSITION + i] - c[at.LENGTH], m[r + at.STEPS + i] * dt
        if (rear > place) & (time <= c[at.CLEAR_BY]) & is_green(m, r + i, c):
            m[r + at.CLEARED + i] = 1.0
        hopeless = (time > c[at.CLEAR_BY]) & (m[r + at.CLEARED + i] == 0.0)
        shadow = m[r + at.SHADOW_POSITION + i]
        if (m[s + at.LIVE + i] != 0.0) & ((rear <= shadow) | (shadow > c[at.FARTHEST]) | hopeless):
            m[r + at.FEASIBLE + i] = 0.0
