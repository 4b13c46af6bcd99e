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
def step_terms(measured: Floats, live: Floats, results: Floats, k: int, c: Floats, low: int, high: int) -> None:
    """Write the four terms of every step; ``live`` is 1 for agents that were running when the step began, else 0."""
    threshold, both = c[layout.JERK_THRESHOLD], c[layout.POSITIVE_JERK_ONLY] == 0.0
    for i in range(low, high):
        jerk = measured[layout.J_E, k, i]
        large = (jerk > threshold) | (both & (jerk < -threshold))
        results[TIME, k, i] = -c[layout.SIGMA_1] * live[i]
        results[UNSMOOTH, k, i] = -c[layout.SIGMA_2] * live[i] if large else 0.0
    for i in range(low, high):
        penalty = unsafe_exp(-measured[layout.DC_RATIO, k, i])
        results[UNSAFE_SSL, k, i] = -penalty * live[i] if measured[layout.D_DC, k, i] < 0.0 else 0.0
    for i in range(low, high):
        penalty = unsafe_exp(-measured[layout.FC_RATIO, k, i])
        results[UNSAFE_FFV, k, i] = -penalty * live[i] if measured[layout.D_FC, k, i] < 0.0 else 0.0


@kernel
def ending_terms(measured: Floats, fresh: Codes, results: Floats, k: int, c: Floats, low: int, high: int) -> None:
    """Write the four terms of the agents that ended in this step; ``fresh`` is their outcome, int8 [agent, row]."""
    for i in range(low, high):
        speed, d_d = measured[layout.V_E, k, i], measured[layout.D_D, k, i]
        results[NOT_STOP, k, i] = -speed * speed if fresh[k, i] == RAN_LINE else 0.0
        results[TIMEOUT, k, i] = -c[layout.TIMEOUT_SCALE] * d_d * d_d if fresh[k, i] == TIMED_OUT else 0.0
    for i in range(low, high):
        results[COLLISION, k, i] = -c[layout.SIGMA_3] if fresh[k, i] == COLLIDED else 0.0
        results[SUCCESS, k, i] = c[layout.SIGMA_4] if fresh[k, i] == SUCCEEDED else 0.0


@kernel
def combine(results: Floats, k: int, low: int, high: int) -> None:
    """Write r^task, r^option and r^action of every option from the terms."""
    for i in range(low, high):
        sr = results[TIME, k, i] + results[TIMEOUT, k, i] + results[SUCCESS, k, i]
        ssl = results[UNSAFE_SSL, k, i] + results[NOT_STOP, k, i]
        ffv = results[UNSAFE_FFV, k, i] + results[COLLISION, k, i]
        smooth = sr + results[UNSMOOTH, k, i]
        results[layout.REWARD_TASK, k, i] = smooth + ssl + ffv
        results[layout.REWARD_OPTION, k, i] = sr + ffv
        results[layout.REWARD_OPTION + 1, k, i] = sr + ssl
        results[layout.REWARD_ACTION, k, i] = smooth + ssl
        results[layout.REWARD_ACTION + 1, k, i] = smooth + ffv


@kernel
def reward(
    measured: Floats, live: Floats, fresh: Codes, results: Floats, k: int, c: Floats, low: int, high: int
) -> None:
    """Write the terms and rewards of agent ``k``, float64 [RESULTS_SIZE, agent, row], from the true measurements."""
    step_terms(measured, live, results, k, c, low, high)
    ending_terms(measured, fresh, results, k, c, low, high)
    combine(results, k, low, high)
