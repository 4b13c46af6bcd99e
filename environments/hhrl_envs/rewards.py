"""The hybrid reward, term by term.

Every step yields eight signed terms (the indices below are columns of ``Simulator.terms``)::

    TIME        -sigma_1
    UNSMOOTH    -sigma_2                     if |j_e| > threshold
    UNSAFE_SSL  -exp(-d_dc / d_ds)           if d_dc < 0
    UNSAFE_FFV  -exp(-d_fc / d_fs)           if d_fc < 0
    COLLISION   -sigma_3                     on a collision            (the failure of FFV)
    NOT_STOP    -v_e^2                       on running the line       (the failure of SSL)
    TIMEOUT     -timeout_scale * d_d^2       on the time limit
    SUCCESS     +sigma_4                     on success

With sr = TIME + TIMEOUT + SUCCESS, k an option and k- the other one::

    r^option[k] = sr + unsafe[k-] + failure[k-]
    r^action[k] = sr + UNSMOOTH + unsafe[k] + failure[k]
    r^task      = sr + UNSMOOTH + all unsafe + all failures = r^option[k] + r^action[k] - sr

An unselected sub-goal that fails is the option level's fault, the selected one the action level's. For more than two
sub-goals, k- stands for all the others.
"""

from hhrl_envs import layout
from hhrl_envs.compiled import Codes, Floats, kernel
from hhrl_envs.observation import MIN_STOPPING_DISTANCE, safety_distance, stopping_distance
from hhrl_envs.outcomes import COLLISION as COLLIDED
from hhrl_envs.outcomes import NOT_STOP as RAN_LINE
from hhrl_envs.outcomes import SUCCESS as SUCCEEDED
from hhrl_envs.outcomes import TIMEOUT as TIMED_OUT

TIME, UNSMOOTH, UNSAFE_SSL, UNSAFE_FFV = layout.TIME, layout.UNSMOOTH, layout.UNSAFE_SSL, layout.UNSAFE_FFV
COLLISION, NOT_STOP, TIMEOUT, SUCCESS = layout.COLLISION, layout.NOT_STOP, layout.TIMEOUT, layout.SUCCESS


@kernel
def unsafe_exp(x: float) -> float:
    """Return exp(x) for x clipped to [0, 1], by the Taylor series of exp(x/4) raised to the fourth power.

    Only + and *: the same bits on every machine and at every vector width; within 2e-15 of the true value, relatively.
    """
    y = min(max(x, 0.0), 1.0) * 0.25
    s = 1.0 + y * (1.0 / 11.0)
    s = 1.0 + y * (1.0 / 10.0) * s
    s = 1.0 + y * (1.0 / 9.0) * s
    s = 1.0 + y * (1.0 / 8.0) * s
    s = 1.0 + y * (1.0 / 7.0) * s
    s = 1.0 + y * (1.0 / 6.0) * s
    s = 1.0 + y * (1.0 / 5.0) * s
    s = 1.0 + y * (1.0 / 4.0) * s
    s = 1.0 + y * (1.0 / 3.0) * s
    s = 1.0 + y * (1.0 / 2.0) * s
    s = 1.0 + y * s
    s = s * s
    return s * s


@kernel
def step_terms(state: Floats, live: Floats, results: Floats, c: Floats, rows: int) -> None:
    """Write the four terms of every step; ``live`` is 1 for rows that were running when the step began, else 0."""
    length, sensor, limit = c[layout.LENGTH], c[layout.SENSOR_RANGE], c[layout.SPEED_LIMIT]
    threshold, both = c[layout.JERK_THRESHOLD], c[layout.POSITIVE_JERK_ONLY] == 0.0
    for i in range(rows):
        jerk = state[layout.JERK, 0, i]
        large = (jerk > threshold) | (both & (jerk < -threshold))
        results[TIME, i] = -c[layout.SIGMA_1] * live[i]
        results[UNSMOOTH, i] = -c[layout.SIGMA_2] * live[i] if large else 0.0
    for i in range(rows):
        d_ds = stopping_distance(state[layout.SPEED, 0, i], c)
        d_dc = -state[layout.POSITION, 0, i] - d_ds
        penalty = unsafe_exp(-d_dc / max(d_ds, MIN_STOPPING_DISTANCE))
        results[UNSAFE_SSL, i] = -penalty * live[i] if d_dc < 0.0 else 0.0
    for i in range(rows):
        gap = state[layout.POSITION, 1, i] - length - state[layout.POSITION, 0, i]
        seen = gap <= sensor
        d_fs = safety_distance(state[layout.SPEED, 0, i], state[layout.SPEED, 1, i] if seen else limit, c)
        d_fc = (gap if seen else sensor) - d_fs
        results[UNSAFE_FFV, i] = -unsafe_exp(-d_fc / d_fs) * live[i] if d_fc < 0.0 else 0.0


@kernel
def ending_terms(state: Floats, fresh: Codes, results: Floats, c: Floats, rows: int) -> None:
    """Write the four terms of the rows that ended in this step; ``fresh`` is their outcome, int8 [B]."""
    for i in range(rows):
        speed, d_d = state[layout.SPEED, 0, i], -state[layout.POSITION, 0, i]
        results[COLLISION, i] = -c[layout.SIGMA_3] if fresh[i] == COLLIDED else 0.0
        results[NOT_STOP, i] = -speed * speed if fresh[i] == RAN_LINE else 0.0
        results[TIMEOUT, i] = -c[layout.TIMEOUT_SCALE] * d_d * d_d if fresh[i] == TIMED_OUT else 0.0
        results[SUCCESS, i] = c[layout.SIGMA_4] if fresh[i] == SUCCEEDED else 0.0


@kernel
def combine(results: Floats, rows: int) -> None:
    """Write r^task, r^option and r^action of every option from the terms."""
    for i in range(rows):
        sr = results[TIME, i] + results[TIMEOUT, i] + results[SUCCESS, i]
        ssl = results[UNSAFE_SSL, i] + results[NOT_STOP, i]
        ffv = results[UNSAFE_FFV, i] + results[COLLISION, i]
        unsmooth = results[UNSMOOTH, i]
        results[layout.REWARD_TASK, i] = sr + unsmooth + ssl + ffv
        results[layout.REWARD_OPTION, i] = sr + ffv
        results[layout.REWARD_OPTION + 1, i] = sr + ssl
        results[layout.REWARD_ACTION, i] = sr + unsmooth + ssl
        results[layout.REWARD_ACTION + 1, i] = sr + unsmooth + ffv


@kernel
def reward(state: Floats, live: Floats, fresh: Codes, results: Floats, c: Floats, rows: int) -> None:
    """Write the terms and rewards of one step, float64 [RESULTS_SIZE, B]."""
    step_terms(state, live, results, c, rows)
    ending_terms(state, fresh, results, c, rows)
    combine(results, rows)
