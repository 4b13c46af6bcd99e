"""Front vehicles: scripted ones, which are IDM car following plus the behaviour at a stop-line, and learned ones.

A vehicle approaches its active line; once stopping there would take ``line_decel`` it brakes with exactly the
deceleration that is needed; having stopped it dwells, then it leaves. A rolling vehicle brakes down to ``line_speed``
and leaves without a halt; one that runs lines never has one. When its rear has passed a line, the next one becomes
active. A vehicle that stands because of its leader starts only after its start delay, once there is room. Whatever a
profile asks for, a safe-speed bound in the manner of Krauss (1998) keeps every follower able to stop behind its
leader, so that scripted vehicles never overlap.

A learned front vehicle is driven by an agent until its episode ends, and by nobody or a script afterwards.
"""

from math import sqrt

from hhrl_envs.arrays import Floats
from hhrl_envs.scenario.scenario import GRAVITY, STOP, Scenario
from hhrl_envs.simulation.dynamics import drive_agent
from hhrl_envs.simulation.engine import layout as at
from hhrl_envs.simulation.engine.compilation import inner, spliced, unsigned
from hhrl_envs.simulation.engine.layout import APPROACHING, BRAKING, DWELLING, FAR, LEAVING
from hhrl_envs.sub_goals import NOT_STOP, SUCCESS

HARDEST_DECEL = 9.0  # m/s^2; what a scripted vehicle brakes with at most on a dry road
GUARD_MARGIN = 0.5  # m; what the safe-speed bound keeps free at the least
ARRIVED = 1.5  # m; a standing vehicle this near to its stop position has arrived at it
RELEASE = 0.3  # a braking vehicle that needs less than this share of its line_decel drives on towards the line
STANDSTILL = 0.01  # m/s; slower is standing, else IDM would creep for ever, down to denormal speeds
CLOSEST = 0.1  # m; floor of distances in denominators


def hardest_decel(scenario: Scenario) -> float:
    """Return what a scripted vehicle brakes with at most in any world, in m/s^2."""
    return min(HARDEST_DECEL, scenario.road.frictions[1] * GRAVITY)


def guard_margin(scenario: Scenario) -> float:
    """Return the metres that the safe-speed bound keeps free.

    Who comes to a stand within a step of dt brakes less hard than b = ``hardest_decel`` in it, which may take
    b dt^2 / 8 more than a stop at b.
    """
    return max(GUARD_MARGIN, hardest_decel(scenario) * scenario.dt * scenario.dt / 6.0)


def fastest_front(scenario: Scenario) -> float:
    """Return a speed that no front vehicle exceeds, in m/s."""
    traffic = scenario.traffic
    wanted = max(scenario.road.speed_limit, traffic.speed[1], *(family.desired_speed[1] for family in traffic.families))
    return wanted + max(1.0, quickest_start(scenario) * scenario.dt)


def quickest_start(scenario: Scenario) -> float:
    """Return the highest acceleration of a scripted vehicle, in m/s^2."""
    return max(family.max_accel[1] for family in scenario.traffic.families)


@inner
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


@inner
def needed_decel(v: float, v_line: float, distance: float) -> float:
    """Return the constant deceleration that brings speed ``v`` to ``v_line`` within ``distance``."""
    return (v * v - v_line * v_line) / (2.0 * max(distance, CLOSEST))


@inner
def safe_speed(v: float, room: float, v_leader: float, dt: float, hardest: float) -> float:
    """Return the largest next speed from which a stop behind the leader stays possible at ``hardest`` deceleration b.

    ``room``, the gap less the margin, and ``v_leader`` are those after the leader moved. It solves
    ``(v + w) dt / 2 + w^2 / (2 b) <= room + v_leader^2 / (2 b)`` for w.
    """
    half = 0.5 * hardest * dt
    room = 2.0 * hardest * (room - v * (0.5 * dt)) + v_leader * v_leader
    return sqrt(max(half * half + room, 0.0)) - half


@inner
def next_phase(
    phase: float, still: bool, to_stop: float, needed: float, line_decel: float, full: bool, rested: bool
) -> tuple[float, bool, bool]:
    """Return the phase after this step's facts, and whether it is BRAKING or DWELLING.

    See the module's text for the cycle of phases.
    """
    heading, braked = phase <= BRAKING, phase == BRAKING
    arriving, passing = full & (to_stop <= ARRIVED), (not full) & (to_stop <= 0.0)
    enough = RELEASE * line_decel if braked else line_decel
    dwelling = (heading & arriving & still) | ((phase == DWELLING) & (not rested))
    braking = heading & (not passing) & (not dwelling) & ((needed >= enough) | (braked & arriving))
    ahead = APPROACHING if heading & (not passing) else LEAVING
    return DWELLING if dwelling else (BRAKING if braking else ahead), braking, dwelling


@inner
def drive_slot(m: Floats, s: int, c: Floats, special: bool | None, lanes: int) -> None:
    """Advance the scripted vehicles of record ``s`` by one step; their leaders, in the next record, have moved already.

    For ``special`` see ``step.advance_rows``: only there a row has its own friction.

    At the end a slow-down begins where the place of one is reached, and where a vehicle's rear has passed a line the
    next line becomes active.
    """
    dt, per_dt, length, last = c[at.DT], c[at.PER_DT], c[at.LENGTH], c[at.LAST_LINE]
    half_step, usual, free = 0.5 * dt, c[at.FRICTION] * GRAVITY, c[at.FREE_THROTTLE]
    leader, margin = s + at.VEHICLE, c[at.GUARD]
    for i in range(lanes):
        grip = usual if special is None else m[s + at.ROAD_FRICTION + i] * GRAVITY
        hardest = min(HARDEST_DECEL, grip)
        x, v, standing = m[s + at.POSITION + i], m[s + at.SPEED + i], m[s + at.STANDING + i]
        gap, v_leader = m[leader + at.POSITION + i] - length - x, m[leader + at.SPEED + i]
        v_line, line_decel, line = m[s + at.LINE_SPEED + i], m[s + at.LINE_DECEL + i], m[s + at.LINE + i]

        to_stop, full, still = line - m[s + at.STOP_POSITION + i] - x, v_line == 0.0, v == 0.0
        needed = needed_decel(v, v_line, to_stop)
        rested = standing >= m[s + at.DWELL + i]
        phase, braking, dwelling = next_phase(m[s + at.PHASE + i], still, to_stop, needed, line_decel, full, rested)

        a = idm(
            v, v_leader, gap, m[s + at.PER_DESIRED_SPEED + i], m[s + at.HEADWAY + i],
            m[s + at.MAX_ACCEL + i], m[s + at.INTERACTION + i], m[s + at.MIN_GAP + i],
        )  # fmt: skip
        a = a if special is None else min(a, max(grip, free))
        for_line = max(needed, line_decel) if full & (to_stop <= ARRIVED) else needed
        a = min(a, -for_line) if braking else a
        slowing = m[s + at.SLOWING + i]
        a = min(a, -m[s + at.SLOW_DECEL + i]) if slowing > 0.0 else a
        starting = (a > 0.0) | dwelling
        held = still & (dwelling | (standing < m[s + at.START_DELAY + i]))
        a = 0.0 if held else max(a, -hardest)

        moved = min(v + a * dt, safe_speed(v, gap - margin, v_leader, dt, hardest))
        stands = moved < STANDSTILL
        moved = 0.0 if stands else moved
        x = x + (v + moved) * half_step
        m[s + at.POSITION + i] = x
        m[s + at.SPEED + i] = moved
        m[s + at.ACCEL + i] = (moved - v) * per_dt
        m[s + at.STANDING + i] = standing + dt if stands & starting else 0.0

        place, slow_time, next_line = m[s + at.NEXT_SLOW + i], m[s + at.SLOW_TIME + i], last if line < last else FAR
        next_place = place + m[s + at.SLOW_EVERY + i]
        reached, passed = x >= place, x - length > line
        m[s + at.SLOWING + i] = slow_time if reached else slowing - dt
        m[s + at.NEXT_SLOW + i] = next_place if reached else place
        m[s + at.PHASE + i] = APPROACHING if passed else phase
        m[s + at.LINE + i] = next_line if passed else line


@spliced
def drive_traffic(m: Floats, s: int, c: Floats, special: bool | None, lanes: int) -> None:
    """Move all scripted vehicles by one step, from the front of the queue to its back."""
    slots, agents = unsigned(c[at.SLOTS]), unsigned(c[at.AGENTS])
    for behind in range(slots - unsigned(1) - agents):
        drive_slot(m, s + (slots - unsigned(2) - behind) * at.VEHICLE, c, special, lanes)


@inner
def drive_front(m: Floats, s: int, c: Floats, special: bool | None, lanes: int) -> None:
    """Advance the learned front vehicles of record ``s`` by one step.

    One that has succeeded or run the line is handed over to the scripted profile drawn for it. One that collided or was
    struck brakes fully, and the wreck stays.
    """
    one = unsigned(1)
    for i in range(lanes):
        outcome = m[s + at.OUTCOME + i]
        if (outcome == SUCCESS) | (outcome == NOT_STOP):
            if m[s + at.FRESH + i] == outcome:
                hand_over(m, s + i, c)
            drive_on(m, s + i, c, special)
        else:
            drive_agent(m, s + i, c, special, one)


@inner
def hand_over(m: Floats, s: int, c: Floats) -> None:
    """Let the vehicle ``s``, a record plus a lane, dwell from now on where it has come to a stand, else drive on."""
    stopped = (c[at.GOAL] == STOP) & (m[s + at.SPEED] < c[at.STOP_SPEED])
    m[s + at.PHASE] = DWELLING if stopped else LEAVING
    m[s + at.SPEED] = 0.0 if stopped else m[s + at.SPEED]
    m[s + at.STANDING] = 0.0


@inner
def drive_on(m: Floats, s: int, c: Floats, special: bool | None) -> None:
    """Advance the vehicle ``s``, a record plus a lane, by one scripted step, with a scripted vehicle's brakes.

    It may have been handed over too fast and too near to its leader for any brakes. Then it runs into it: the bound on
    its speed, which assumes that it has always kept its distance, would stop it dead.
    """
    x, v = m[s + at.POSITION], m[s + at.SPEED]
    drive_slot(m, s, c, special, unsigned(1))
    slowest = v - min(HARDEST_DECEL, m[s + at.ROAD_FRICTION] * GRAVITY) * c[at.DT]
    if m[s + at.SPEED] < slowest:
        m[s + at.POSITION] = x + 0.5 * (v + slowest) * c[at.DT]
        m[s + at.ACCEL] = (slowest - v) * c[at.PER_DT]
        m[s + at.SPEED] = slowest
