"""Scripted front vehicles: IDM car following plus the behaviour at the stop-line.

A vehicle approaches; once stopping at the line would take ``line_decel`` it brakes with exactly the deceleration that
is needed; having stopped at the line it dwells, then it leaves. A rolling vehicle brakes down to ``line_speed`` and
leaves without a halt; one that runs the line is leaving from the start. A vehicle that stands because of its leader
starts only after its start delay, once there is room. Whatever a profile asks for, a safe-speed bound in the manner of
Krauss (1998) keeps every follower able to stop behind its leader, so that scripted vehicles never overlap.
"""

from math import sqrt

from hhrl_envs import layout
from hhrl_envs.compiled import Floats, kernel
from hhrl_envs.layout import APPROACHING, BRAKING, DWELLING, LEAVING

HARDEST_DECEL = 9.0  # m/s^2; dry-road limit of every scripted vehicle
GUARD_MARGIN = 0.5  # m; what the safe-speed bound keeps free
ARRIVED = 1.5  # m; a standing vehicle this near to its stop position has arrived at it
RELEASE = 0.3  # a braking vehicle that needs less than this share of its line_decel drives on towards the line
CLOSEST = 0.1  # m; floor of distances in denominators


@kernel
def idm(
    v: float, v_leader: float, gap: float, desired: float, headway: float, accel: float, decel: float, s0: float
) -> float:
    """Return the IDM acceleration (Treiber et al. 2000, delta = 4)."""
    wanted_gap = s0 + max(0.0, v * headway + v * (v - v_leader) / (2.0 * sqrt(accel * decel)))
    crowding = wanted_gap / max(gap, CLOSEST)
    ratio = v / desired
    return accel * (1.0 - ratio * ratio * ratio * ratio - crowding * crowding)


@kernel
def needed_decel(v: float, v_line: float, distance: float) -> float:
    """Return the constant deceleration that brings speed ``v`` to ``v_line`` within ``distance``."""
    return (v * v - v_line * v_line) / (2.0 * max(distance, CLOSEST))


@kernel
def safe_speed(v: float, gap: float, v_leader: float, dt: float) -> float:
    """Return the largest next speed from which a stop behind the leader stays possible at ``HARDEST_DECEL``.

    ``gap`` and ``v_leader`` are those after the leader moved. It solves
    ``(v + w) dt / 2 + w^2 / (2 b) <= gap + v_leader^2 / (2 b)`` for w.
    """
    half = 0.5 * HARDEST_DECEL * dt
    room = gap - GUARD_MARGIN + v_leader * v_leader / (2.0 * HARDEST_DECEL) - 0.5 * v * dt
    return sqrt(max(half * half + 2.0 * HARDEST_DECEL * room, 0.0)) - half


@kernel
def next_phase(
    phase: float, v: float, to_stop: float, needed: float, line_decel: float, full: bool, rested: bool
) -> float:
    """Return the phase after this step's facts; see the module's text for the cycle of phases."""
    towards = (phase == APPROACHING) | (phase == BRAKING)
    arriving = full & (to_stop <= ARRIVED)
    braking = (needed >= line_decel) | ((phase == BRAKING) & (arriving | (needed >= RELEASE * line_decel)))
    heading = BRAKING if braking else APPROACHING
    heading = DWELLING if arriving & (v == 0.0) else heading
    heading = LEAVING if (not full) & (to_stop <= 0.0) else heading
    resting = LEAVING if rested else DWELLING
    return heading if towards else (resting if phase == DWELLING else LEAVING)


@kernel
def drive_slot(state: Floats, profile: Floats, k: int, c: Floats, rows: int) -> None:
    """Advance the scripted vehicle in slot ``k`` of every row by one step; its leader has moved already."""
    dt, length = c[layout.DT], c[layout.LENGTH]
    for i in range(rows):
        x, v, phase = state[layout.POSITION, k, i], state[layout.SPEED, k, i], state[layout.PHASE, k, i]
        standing, slowing = state[layout.STANDING, k, i], state[layout.SLOWING, k, i]
        gap, v_leader = state[layout.POSITION, k + 1, i] - length - x, state[layout.SPEED, k + 1, i]
        v_line, delay = profile[layout.LINE_SPEED, k, i], profile[layout.START_DELAY, k, i]

        to_stop = -profile[layout.STOP_POSITION, k, i] - x
        needed = needed_decel(v, v_line, to_stop)
        rested = standing >= profile[layout.DWELL, k, i]
        full, line_decel = v_line == 0.0, profile[layout.LINE_DECEL, k, i]
        phase = next_phase(phase, v, to_stop, needed, line_decel, full, rested)

        a = idm(
            v, v_leader, gap, profile[layout.DESIRED_SPEED, k, i], profile[layout.HEADWAY, k, i],
            profile[layout.MAX_ACCEL, k, i], profile[layout.COMFORT_DECEL, k, i], profile[layout.MIN_GAP, k, i],
        )  # fmt: skip
        braking = max(needed, line_decel) if full & (to_stop <= ARRIVED) else needed
        a = min(a, -braking) if phase == BRAKING else a
        a = min(a, -profile[layout.SLOW_DECEL, k, i]) if slowing > 0.0 else a
        wants = (a > 0.0) | (phase == DWELLING)
        held = (v == 0.0) & ((phase == DWELLING) | (standing < delay))
        a = 0.0 if held else max(a, -HARDEST_DECEL)

        moved = max(min(v + a * dt, safe_speed(v, gap, v_leader, dt)), 0.0)
        ahead = x + 0.5 * (v + moved) * dt
        slow_from = -profile[layout.SLOW_AT, k, i]
        crossed = (x < slow_from) & (ahead >= slow_from)
        state[layout.POSITION, k, i] = ahead
        state[layout.SPEED, k, i] = moved
        state[layout.ACCEL, k, i] = (moved - v) / dt
        state[layout.PHASE, k, i] = phase
        state[layout.STANDING, k, i] = standing + dt if (moved == 0.0) & wants else 0.0
        state[layout.SLOWING, k, i] = profile[layout.SLOW_TIME, k, i] if crossed else slowing - dt


@kernel
def drive_traffic(state: Floats, profile: Floats, c: Floats, rows: int) -> None:
    """Advance every scripted vehicle by one step, from the front to the back of the queue."""
    for k in range(state.shape[1] - 2, 0, -1):
        drive_slot(state, profile, k, c, rows)
