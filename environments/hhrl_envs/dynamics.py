"""The longitudinal motion of agents: target accelerations, one first-order actuator, no reverse gear."""

from hhrl_envs import layout
from hhrl_envs.compiled import Floats, kernel


@kernel
def actuate(accel: float, target: float, c: Floats) -> float:
    """Return the next acceleration: a first-order lag towards ``target``, within the jerk limit and the road's grip."""
    change = (target - accel) * float(c[layout.LAG_GAIN])
    most, grip = float(c[layout.JERK_STEP]), float(c[layout.GRIP])
    return min(max(accel + min(max(change, -most), most), -grip), grip)


@kernel
def drive_agent(state: Floats, targets: Floats, k: int, c: Floats, low: int, high: int) -> None:
    """Advance the agent in slot ``k`` of rows low to high by one step towards its target accelerations, float64 [row].

    The speed stays within [0, speed limit]; the acceleration kept is the one realised. The position follows the
    trapezoidal rule, so that it is exact for a constant acceleration.
    """
    dt, per_dt, limit = c[layout.DT], c[layout.PER_DT], c[layout.SPEED_LIMIT]
    for i in range(low, high):
        before, speed = state[layout.ACCEL, k, i], state[layout.SPEED, k, i]
        moved = min(max(speed + actuate(before, targets[i], c) * dt, 0.0), limit)
        accel = (moved - speed) * per_dt
        state[layout.POSITION, k, i] += 0.5 * (speed + moved) * dt
        state[layout.SPEED, k, i] = moved
        state[layout.ACCEL, k, i] = accel
        state[layout.JERK, k, i] = (accel - before) * per_dt
