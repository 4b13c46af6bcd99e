"""The ego's longitudinal motion: discrete levels, one first-order actuator, no reverse gear."""

from hhrl_envs import layout
from hhrl_envs.compiled import Floats, kernel


@kernel
def actuate(accel: float, target: float, c: Floats) -> float:
    """Return the next actuator acceleration: a first-order lag towards ``target``, within the jerk limit."""
    change = (target - accel) * float(c[layout.LAG_GAIN])
    most = float(c[layout.JERK_STEP])
    return accel + min(max(change, -most), most)


@kernel
def integrate(position: float, speed: float, accel: float, c: Floats) -> tuple[float, float, float]:
    """Return position, speed and realised acceleration one step later; the speed stays within [0, speed limit].

    The position follows the trapezoidal rule, so that it is exact for a constant acceleration.
    """
    moved = min(max(speed + accel * c[layout.DT], 0.0), c[layout.SPEED_LIMIT])
    return position + 0.5 * (speed + moved) * c[layout.DT], moved, (moved - speed) / c[layout.DT]


@kernel
def drive_ego(state: Floats, targets: Floats, c: Floats, rows: int) -> None:
    """Advance slot 0 of the first ``rows`` rows by one step towards its target accelerations, float64 [B]."""
    for i in range(rows):
        before = state[layout.ACCEL, 0, i]
        wanted = actuate(before, targets[i], c)
        x, v, a = integrate(state[layout.POSITION, 0, i], state[layout.SPEED, 0, i], wanted, c)
        state[layout.POSITION, 0, i] = x
        state[layout.SPEED, 0, i] = v
        state[layout.ACCEL, 0, i] = a
        state[layout.JERK, 0, i] = (a - before) / c[layout.DT]
