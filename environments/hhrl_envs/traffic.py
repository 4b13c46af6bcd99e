"""Scripted front vehicles: IDM car following plus the behaviour at a stop-line.

A vehicle approaches its active line; once stopping there would take ``line_decel`` it brakes with exactly the
deceleration that is needed; having stopped it dwells, then it leaves. A rolling vehicle brakes down to ``line_speed``
and leaves without a halt; one that runs lines never has one. When its rear has passed a line, the next one becomes
active. A vehicle that stands because of its leader starts only after its start delay, once there is room. Whatever a
profile asks for, a safe-speed bound in the manner of Krauss (1998) keeps every follower able to stop behind its
leader, so that scripted vehicles never overlap.
"""

from math import sqrt

from hhrl_envs import layout
from hhrl_envs.compiled import Floats, kernel
from hhrl_envs.layout import APPROACHING, BRAKING, DWELLING, FAR, LEAVING

HARDEST_DECEL = 9.0  # m/s^2; what a scripted vehicle brakes with at most on a dry road
GUARD_MARGIN = 0.5  # m; what the safe-speed bound keeps free
ARRIVED = 1.5  # m; a standing vehicle this near to its stop position has arrived at it
RELEASE = 0.3  # a braking vehicle that needs less than this share of its line_decel drives on towards the line
STANDSTILL = 0.01  # m/s; slower is standing, else IDM would creep for ever, down to denormal speeds
CLOSEST = 0.1  # m; floor of distances in denominators


@kernel
def idm(
    v: float,
    v_leader: float,
    gap: float,
    per_desired: float,
    headway: float,
    accel: float,
    interaction: float,
    s0: float,
) -> float:
    """Return the IDM acceleration (Treiber et al. 2000, delta = 4).

    ``per_desired`` is 1 / desired speed, ``accel`` the maximum acceleration a, ``interaction`` 1 / (2 sqrt(a b)) with
    the comfortable deceleration b, ``s0`` the minimum gap.
    """
    wanted_gap = s0 + max(0.0, v * headway + v * (v - v_leader) * interaction)
    crowding = wanted_gap / max(gap, CLOSEST)
    ratio = v * per_desired
    square = ratio * ratio
    return accel * (1.0 - square * square - crowding * crowding)


@kernel
def needed_decel(v: float, v_line: float, distance: float) -> float:
    """Return the constant deceleration that brings speed ``v`` to ``v_line`` within ``distance``."""
    return (v * v - v_line * v_line) / (2.0 * max(distance, CLOSEST))


@kernel
def safe_speed(v: float, gap: float, v_leader: float, dt: float, hardest: float) -> float:
    """Return the largest next speed from which a stop behind the leader stays possible at ``hardest`` deceleration b.

    ``gap`` and ``v_leader`` are those after the leader moved. It solves
    ``(v + w) dt / 2 + w^2 / (2 b) <= gap + v_leader^2 / (2 b)`` for w.
    """
    half = 0.5 * hardest * dt
    room = 2.0 * hardest * (gap - GUARD_MARGIN - 0.5 * v * dt) + v_leader * v_leader
    return sqrt(max(half * half + room, 0.0)) - half


@kernel
def pass_places(state: Floats, profile: Floats, k: int, c: Floats, low: int, high: int) -> None:
    """Begin a slow-down where slot ``k`` reaches the place of one, and the next line where its rear has passed one."""
    dt, length, last = c[layout.DT], c[layout.LENGTH], c[layout.LAST_LINE]
    for i in range(low, high):
        place, slowing = state[layout.NEXT_SLOW, k, i], state[layout.SLOWING, k, i] - dt
        reached = state[layout.POSITION, k, i] >= place
        state[layout.SLOWING, k, i] = profile[layout.SLOW_TIME, k, i] if reached else slowing
        state[layout.NEXT_SLOW, k, i] = place + profile[layout.SLOW_EVERY, k, i] if reached else place
    for i in range(low, high):
        line, phase = state[layout.LINE, k, i], state[layout.PHASE, k, i]
        passed = state[layout.POSITION, k, i] - length > line
        state[layout.PHASE, k, i] = APPROACHING if passed else phase
        state[layout.LINE, k, i] = (last if line < last else FAR) if passed else line


@kernel
def next_phase(
    phase: float, v: float, to_stop: float, needed: float, line_decel: float, full: bool, rested: bool
) -> float:
    """Return the phase after this step's facts; see the module's text for the cycle of phases."""
    arriving = full & (to_stop <= ARRIVED)
    braking = (needed >= line_decel) | ((phase == BRAKING) & (arriving | (needed >= RELEASE * line_decel)))
    heading = BRAKING if braking else APPROACHING
    heading = DWELLING if arriving & (v == 0.0) else heading
    heading = LEAVING if (not full) & (to_stop <= 0.0) else heading
    resting = DWELLING if (phase == DWELLING) & (not rested) else LEAVING
    return heading if phase <= BRAKING else resting


@kernel
def drive_slot(state: Floats, profile: Floats, k: int, c: Floats, low: int, high: int) -> None:
    """Advance the scripted vehicles in slot ``k`` of rows low to high by one step; their leaders have moved already."""
    dt, per_dt, length = c[layout.DT], c[layout.PER_DT], c[layout.LENGTH]
    hardest = min(HARDEST_DECEL, c[layout.GRIP])
    for i in range(low, high):
        x, v, standing = state[layout.POSITION, k, i], state[layout.SPEED, k, i], state[layout.STANDING, k, i]
        gap, v_leader = state[layout.POSITION, k + 1, i] - length - x, state[layout.SPEED, k + 1, i]
        v_line, line_decel = profile[layout.LINE_SPEED, k, i], profile[layout.LINE_DECEL, k, i]

        to_stop, full = state[layout.LINE, k, i] - profile[layout.STOP_POSITION, k, i] - x, v_line == 0.0
        needed = needed_decel(v, v_line, to_stop)
        rested = standing >= profile[layout.DWELL, k, i]
        phase = next_phase(state[layout.PHASE, k, i], v, to_stop, needed, line_decel, full, rested)
        dwelling = phase == DWELLING

        a = idm(
            v, v_leader, gap, profile[layout.PER_DESIRED_SPEED, k, i], profile[layout.HEADWAY, k, i],
            profile[layout.MAX_ACCEL, k, i], profile[layout.INTERACTION, k, i], profile[layout.MIN_GAP, k, i],
        )  # fmt: skip
        for_line = max(needed, line_decel) if full & (to_stop <= ARRIVED) else needed
        a = min(a, -for_line) if phase == BRAKING else a
        a = min(a, -profile[layout.SLOW_DECEL, k, i]) if state[layout.SLOWING, k, i] > 0.0 else a
        starting = (a > 0.0) | dwelling
        held = (v == 0.0) & (dwelling | (standing < profile[layout.START_DELAY, k, i]))
        a = 0.0 if held else max(a, -hardest)

        moved = min(v + a * dt, safe_speed(v, gap, v_leader, dt, hardest))
        moved = moved if moved >= STANDSTILL else 0.0
        state[layout.POSITION, k, i] = x + 0.5 * (v + moved) * dt
        state[layout.SPEED, k, i] = moved
        state[layout.ACCEL, k, i] = (moved - v) * per_dt
        state[layout.STANDING, k, i] = standing + dt if (moved == 0.0) & starting else 0.0
        state[layout.PHASE, k, i] = phase
    pass_places(state, profile, k, c, low, high)
