"""The hybrid reward, term by term, for any number of sub-goals.

Every step yields signed terms, whose names in the order of the columns of ``Simulator.terms`` are ``TERMS``::

    TIME        -sigma_1
    UNSMOOTH    -sigma_2                     if |j_e| > threshold
    UNSAFE_SSL  -exp(-d_dc / d_ds)           if d_dc < 0
    UNSAFE_FFV  -exp(-d_fc / d_fs)           if d_fc < 0
    COLLISION   -sigma_3                     on a collision            (the failure of FFV)
    NOT_STOP    -v_e^2                       on running the line       (the failure of SSL)
    TIMEOUT     -timeout_scale * d_d^2       on the time limit
    SUCCESS     +sigma_4                     on success

With sr = TIME + TIMEOUT + SUCCESS and k the option::

    r^option[k] = sr + unsafe and failure of all sub-goals but k
    r^action[k] = sr + UNSMOOTH + unsafe[k] + failure[k]
    r^task      = sr + UNSMOOTH + unsafe and failure of all sub-goals

so that r^option[k] + r^action[k] - sr = r^task for every k. An unselected sub-goal that fails is the option level's
fault, the selected one the action level's.
"""

from collections.abc import Callable

from hhrl_envs.arrays import Floats
from hhrl_envs.simulation.engine import layout as at
from hhrl_envs.simulation.engine.compilation import in_turn, inlined, inner, unsigned
from hhrl_envs.simulation.sub_goal_kernels import KERNELS
from hhrl_envs.sub_goals import SUB_GOALS
from hhrl_envs.sub_goals import SUCCESS as SUCCEEDED
from hhrl_envs.sub_goals import TIMEOUT as TIMED_OUT


def _column(field: int) -> int:
    return at.count_fields(field) - at.count_fields(at.TERMS)


TIME, UNSMOOTH, TIMEOUT, SUCCESS = map(_column, (at.TIME, at.UNSMOOTH, at.TIMEOUT, at.SUCCESS))
UNSAFE = tuple(map(_column, at.UNSAFE))
"""The columns of the unsafe terms, one a sub-goal."""
FAILURE = tuple(map(_column, at.FAILURE))
"""The columns of the failures' terms, one a sub-goal."""
_FAILURES = tuple(SUB_GOALS[k].failure.name for k in at.FAILURE_ORDER)
TERMS = ("TIME", "UNSMOOTH", *(f"UNSAFE_{goal.spelling}" for goal in SUB_GOALS), *_FAILURES, "TIMEOUT", "SUCCESS")
"""The names of all columns."""


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


Charge = Callable[[Floats, int, float, float, float], None]


def _charge_of(k: int) -> Charge:
    """Return the part of `reward` that writes the terms of sub-goal k for an agent, whose record plus lane is ``s``.

    It adds them to r^task, to r^action of its own option and to r^option of all others.
    """
    critical, ratio = at.measured(SUB_GOALS[k].critical), at.measured(SUB_GOALS[k].ratio)
    outcome, penalty = float(SUB_GOALS[k].failure), KERNELS[k].penalty
    unsafe_term, failure_term, own_action = at.UNSAFE[k], at.FAILURE[k], at.ACTION[k]

    @inlined
    def charge(m: Floats, s: int, live: float, fresh: float, sigma_3: float) -> None:
        cost = penalty(m, s, sigma_3)
        unsafe = unsafety(m[s + critical], m[s + ratio]) * live
        failure = cost if fresh == outcome else 0.0
        m[s + unsafe_term] = unsafe
        m[s + failure_term] = failure
        both = unsafe + failure
        m[s + at.TASK] += both
        m[s + own_action] += both
        for other in range(at.GOALS):
            if other != k:
                m[s + at.OPTION[0] + unsigned(other * at.STRIDE)] += both

    return charge


charge_all = in_turn(map(_charge_of, range(at.GOALS)))


@inner
def reward(m: Floats, s: int, c: Floats, lanes: int) -> None:
    """Write the terms of the agents of record ``s``, and r^task, r^option and r^action of every option.

    Agents that were not running when the step began earn nothing; an ending is rewarded in the step in which it
    happens.
    """
    threshold, both = c[at.JERK_THRESHOLD], c[at.POSITIVE_JERK_ONLY] == 0.0
    per_step, per_jerk, timeout_scale = -c[at.SIGMA_1], -c[at.SIGMA_2], -c[at.TIMEOUT_SCALE]
    sigma_3, per_success = c[at.SIGMA_3], c[at.SIGMA_4]
    for i in range(lanes):
        live, fresh, jerk, d_d = m[s + at.LIVE + i], m[s + at.FRESH + i], m[s + at.J_E + i], m[s + at.D_D + i]
        large = (jerk > threshold) | (both & (jerk < -threshold))
        time, unsmooth = per_step * live, per_jerk * live if large else 0.0
        timeout = timeout_scale * d_d * d_d if fresh == TIMED_OUT else 0.0
        success = per_success if fresh == SUCCEEDED else 0.0
        m[s + at.TIME + i], m[s + at.UNSMOOTH + i] = time, unsmooth
        m[s + at.TIMEOUT + i], m[s + at.SUCCESS + i] = timeout, success
        sr = time + timeout + success
        m[s + at.TASK + i] = sr + unsmooth
        for k in range(at.GOALS):
            m[s + at.OPTION[0] + unsigned(k * at.STRIDE) + i] = sr
            m[s + at.ACTION[0] + unsigned(k * at.STRIDE) + i] = sr + unsmooth
        charge_all(m, s + i, live, fresh, sigma_3)
