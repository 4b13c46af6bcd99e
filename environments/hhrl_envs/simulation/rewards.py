"""The hybrid reward, term by term, for any number of sub-goals.

Every step yields signed terms, whose names in the order of the columns of ``Simulator.terms`` are ``TERMS``::

    TIME        -sigma_1
    UNSMOOTH    -sigma_2                                if |j_e| > threshold
    UNSAFE_SSL  -exp(min(-d_dc / max(d_ds, 0.5 m), 1))  if d_dc < 0
    UNSAFE_FFV  -exp(-d_fc / d_fs)                      if d_fc < 0
    COLLISION   -sigma_3                                on a collision       (the failure of FFV)
    NOT_STOP    -v_e^2                                  on running the line  (the failure of SSL)
    TIMEOUT     -timeout_scale * d_d^2                  on the time limit
    SUCCESS     +sigma_4                                on success

With sr = TIME + TIMEOUT + SUCCESS and k the option::

    r^option[k] = sr + unsafe and failure of all sub-goals but k
    r^action[k] = sr + UNSMOOTH + unsafe[k] + failure[k]
    r^task      = sr + UNSMOOTH + unsafe and failure of all sub-goals

so that r^option[k] + r^action[k] - sr = r^task for every k. An unselected sub-goal that fails is the option level's
fault, the selected one the action level's.

UNSAFE_SSL is printed as -exp(-d_dc / d_ds). Its d_ds = v_e^2 / (2 a_max) goes to 0 with v_e, so that past the line,
where d_d is negative, the exponent -d_dc / d_ds = 1 - d_d / d_ds has no bound. Therefore d_ds is floored at 0.5 m in
the ratio, and the exponent bounded at 1: no unsafe term is below -e. Whether d_dc < 0 is asked of d_ds as it is.
UNSAFE_FFV is the printed term: with d_fs at least d_0 and d_f at least 0 its exponent is at most 1.

With ``Reward(unsafe="printed")`` a scenario has the printed terms: d_ds is not floored, and the exponent, which past
the line is infinite at v_e = 0, is bounded at 32 alone. Then no unsafe term is below -e^32, about -7.9e13.
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


MOST = 32.0
"""What the printed exponent is bounded at: the square of exp(32) is still finite in float32, which learners use."""


@inner
def printed_exp(x: float) -> float:
    """Return exp(x) for x in [0, `MOST`]: up to 1 as `unsafe_exp` does, beyond as exp(x/32) to the power of 32.

    Only + and *, as there; within 1e-13 of the true value, relatively.
    """
    small = x <= 1.0
    power = unsafe_exp(x if small else x * (1.0 / 32.0))
    s = power * power
    s = s * s
    s = s * s
    s = s * s
    s = s * s
    return power if small else s


Unsafety = Callable[[Floats, int, Floats], float]


def _floored(k: int) -> Unsafety:
    """Return what returns the unsafe term of sub-goal k, of a running agent whose record plus lane is ``s``.

    A negative critical distance has a ratio within [-1, 0]; what other ratios give is not used.
    """
    critical, ratio = at.measured(SUB_GOALS[k].critical), at.measured(SUB_GOALS[k].ratio)

    @inlined
    def unsafety(m: Floats, s: int, c: Floats) -> float:  # noqa: ARG001
        penalty = unsafe_exp(-m[s + ratio])
        return -penalty if m[s + critical] < 0.0 else 0.0

    return unsafety


def _printed(k: int) -> Unsafety:
    """Return the same as `_floored` for the term as it is printed."""
    critical, safety = at.measured(SUB_GOALS[k].critical), KERNELS[k].safety

    @inlined
    def unsafety(m: Floats, s: int, c: Floats) -> float:
        distance = m[s + critical]
        penalty = printed_exp(min(-distance / safety(m, s, c), MOST))
        return -penalty if distance < 0.0 else 0.0

    return unsafety


Charge = Callable[[Floats, int, Floats, float, float, float], None]


def _charge_of(k: int, unsafety: Unsafety) -> Charge:
    """Return the part of a reward that writes the terms of sub-goal k for an agent, whose record plus lane is ``s``.

    It adds them to r^task, to r^action of its own option and to r^option of all others.
    """
    outcome, penalty = float(SUB_GOALS[k].failure), KERNELS[k].penalty
    unsafe_term, failure_term, own_action = at.UNSAFE[k], at.FAILURE[k], at.ACTION[k]

    @inlined
    def charge(m: Floats, s: int, c: Floats, live: float, fresh: float, sigma_3: float) -> None:
        cost = penalty(m, s, sigma_3)
        unsafe = unsafety(m, s, c) * live
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


Reward = Callable[[Floats, int, Floats, int], None]


def _reward_by(reading: Callable[[int], Unsafety]) -> Reward:
    """Return what writes the terms of the agents of record ``s``, and r^task, r^option and r^action of every option.

    Agents that were not running when the step began earn nothing; an ending is rewarded in the step in which it
    happens.
    """
    charge_all = in_turn(_charge_of(k, reading(k)) for k in range(at.GOALS))

    @inner
    def reward(m: Floats, s: int, c: Floats, lanes: int) -> None:
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
            charge_all(m, s + i, c, live, fresh, sigma_3)

    return reward


reward_floored, reward_printed = _reward_by(_floored), _reward_by(_printed)


@inner
def reward_as_read(m: Floats, s: int, c: Floats, lanes: int) -> None:
    """Do what `reward_floored` does, by the scenario's reading of the unsafe terms."""
    if c[at.PRINTED_UNSAFE] != 0.0:
        reward_printed(m, s, c, lanes)
    else:
        reward_floored(m, s, c, lanes)
