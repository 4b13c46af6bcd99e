"""The longitudinal motion of agents: target accelerations, one first-order actuator, no reverse gear."""

from math import inf

from hhrl_envs.arrays import Floats
from hhrl_envs.scenario.scenario import GRAVITY
from hhrl_envs.simulation.engine import layout as at
from hhrl_envs.simulation.engine.compilation import inner


@inner
def actuate(accel: float, target: float, gain: float, most: float, grip: float) -> float:
    """Return the next acceleration: a first-order lag towards ``target``, within the jerk limit and the road's grip.

    ``gain`` is the share of the way to the target that a step covers, ``most`` the largest change in a step.
    """
    return min(max(accel + min(max((target - accel) * gain, -most), most), -grip), grip)


@inner
def drive_agent(m: Floats, s: int, c: Floats, special: bool | None, lanes: int) -> None:
    """Advance the agents of record ``s`` by one step towards their target accelerations.

    For ``special`` see ``step.advance_rows``: only there a row has its own friction.

    The speed stays within [0, speed limit]; the acceleration kept is the one realised. The position follows the
    trapezoidal rule, so that it is exact for a constant acceleration.
    """
    dt, per_dt, limit = c[at.DT], c[at.PER_DT], c[at.SPEED_LIMIT]
    gain, most, usual = c[at.LAG_GAIN], c[at.JERK_STEP], c[at.FRICTION] * GRAVITY
    for i in range(lanes):
        grip = usual if special is None else m[s + at.ROAD_FRICTION + i] * GRAVITY
        before, speed = m[s + at.ACCEL + i], m[s + at.SPEED + i]
        moved = min(max(speed + actuate(before, m[s + at.TARGET + i], gain, most, grip) * dt, 0.0), limit)
        accel = (moved - speed) * per_dt
        m[s + at.POSITION + i] += 0.5 * (speed + moved) * dt
        m[s + at.SPEED + i] = moved
        m[s + at.ACCEL + i] = accel
        m[s + at.JERK + i] = (accel - before) * per_dt


@inner
def braking_distance(speed: float, grip: float, c: Floats) -> float:
    """Return the metres that an agent with ``speed`` and no acceleration covers under full braking until it stands.

    ``grip`` is the most that the road lets it brake with, in m/s^2. They are infinite if it does not stand within the
    time limit.
    """
    brake, gain, most = c[at.EGO_MIN_ACCEL], c[at.LAG_GAIN], c[at.JERK_STEP]
    covered, accel = 0.0, 0.0
    for _ in range(int(c[at.HORIZON])):
        if speed == 0.0:
            return covered
        moved = max(speed + actuate(accel, brake, gain, most, grip) * c[at.DT], 0.0)
        accel = (moved - speed) * c[at.PER_DT]
        covered += 0.5 * (speed + moved) * c[at.DT]
        speed = moved
    return covered if speed == 0.0 else inf


@inner
def longest_braking(speed: float, grip: float, c: Floats) -> float:
    """Return metres that ``braking_distance`` surely does not exceed, at the cost of some divisions.

    What the deceleration still lacks of its last value b shrinks in every step by the share LAG_GAIN, or by JERK_STEP
    where that is less: over all steps it adds up to b / gain, and to (b - JERK_STEP / gain)^2 / (2 JERK_STEP) more
    where the jerk is limited. An ego that drives on for as long as it takes b to make up for that, and then brakes
    with b at once, is never slower. Half of b dt^2 is for the step in which the ego comes to a stand.
    """
    brake, gain, most, dt = min(-c[at.EGO_MIN_ACCEL], grip), c[at.LAG_GAIN], c[at.JERK_STEP], c[at.DT]
    limited = max(brake - most / gain, 0.0)
    delay = (brake / gain + limited * limited / (2.0 * most)) * dt / brake
    return float(speed * (delay + speed / (2.0 * brake)) + 0.5 * brake * dt * dt)
