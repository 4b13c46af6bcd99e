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

from hhrl_envs.arrays import Floats
from hhrl_envs.simulation.engine import layout as at
from hhrl_envs.simulation.engine.compilation import inner
from hhrl_envs.sub_goals import COLLISION as COLLIDED
from hhrl_envs.sub_goals import NOT_STOP as RAN_LINE
from hhrl_envs.sub_goals import SUCCESS as SUCCEEDED
from hhrl_envs.sub_goals import TIMEOUT as TIMED_OUT

TIME, UNSMOOTH, UNSAFE_SSL, UNSAFE_FFV, COLLISION, NOT_STOP, TIMEOUT, SUCCESS = range(at.TERMS_SIZE)


@inner
def unsafe_exp(x: float) -> float:
    """Return exp(x) for x in [0, 1], by the Taylor series of exp(x/4) raised to the fourth power.

    Only + and *: the same bits on every machine and at every vector width; within 2e-15 of the true value, relatively.
    """
    y = x * 0.25
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


@inner
def unsafety(distance: float, ratio: float) -> float:
    """Return the penalty of one sub-goal: -exp(-ratio) where the critical distance is negative, else 0.

    A negative distance has a ratio within [-1, 0]; what other ratios give is not used.
    """
    penalty = unsafe_exp(-ratio)
    return -penalty if distance < 0.0 else 0.0


@inner
def reward(m: Floats, s: int, c: Floats, lanes: int) -> None:
    """Write the terms of the agents of record ``s``, and r^task, r^option and r^action of every option.

    Agents that were not running when the step began earn nothing; an ending is rewarded in the step in which it
    happens.
    """
    threshold, both = c[at.JERK_THRESHOLD], c[at.POSITIVE_JERK_ONLY] == 0.0
    per_step, per_jerk, timeout_scale = -c[at.SIGMA_1], -c[at.SIGMA_2], -c[at.TIMEOUT_SCALE]
    per_collision, per_success = -c[at.SIGMA_3], c[at.SIGMA_4]
    for i in range(lanes):
        live, fresh = m[s + at.LIVE + i], m[s + at.FRESH + i]
        jerk, speed, d_d = m[s + at.J_E + i], m[s + at.V_E + i], m[s + at.D_D + i]
        large = (jerk > threshold) | (both & (jerk < -threshold))
        time, unsmooth = per_step * live, per_jerk * live if large else 0.0
        unsafe_ssl = unsafety(m[s + at.D_DC + i], m[s + at.DC_RATIO + i]) * live
        unsafe_ffv = unsafety(m[s + at.D_FC + i], m[s + at.FC_RATIO + i]) * live
        collision = per_collision if fresh == COLLIDED else 0.0
        not_stop = -speed * speed if fresh == RAN_LINE else 0.0
        timeout = timeout_scale * d_d * d_d if fresh == TIMED_OUT else 0.0
        success = per_success if fresh == SUCCEEDED else 0.0
        m[s + at.TIME + i], m[s + at.UNSMOOTH + i] = time, unsmooth
        m[s + at.UNSAFE_SSL + i], m[s + at.UNSAFE_FFV + i] = unsafe_ssl, unsafe_ffv
        m[s + at.COLLISION + i], m[s + at.NOT_STOP + i] = collision, not_stop
        m[s + at.TIMEOUT + i], m[s + at.SUCCESS + i] = timeout, success

        sr = time + timeout + success
        ssl, ffv, smooth = unsafe_ssl + not_stop, unsafe_ffv + collision, sr + unsmooth
        m[s + at.TASK + i] = smooth + ssl + ffv
        m[s + at.OPTION_SSL + i], m[s + at.OPTION_FFV + i] = sr + ffv, sr + ssl
        m[s + at.ACTION_SSL + i], m[s + at.ACTION_FFV + i] = smooth + ssl, smooth + ffv
