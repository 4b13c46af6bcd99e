"""What an agent can measure: the base quantities of the state, and Eq. (dis) computed from them."""

from hhrl_envs import layout
from hhrl_envs.compiled import Floats, Ints, Keys, kernel
from hhrl_envs.streams import normal, stream

MIN_STOPPING_DISTANCE = 0.5  # m; floor of d_ds where it is a denominator
RATIO_LOW, RATIO_HIGH = -1.0, 10.0
NOISE = 7  # purpose of the noise streams


@kernel
def measure(state: Floats, measured: Floats, k: int, c: Floats, low: int, high: int) -> None:
    """Write the true base quantities of agent ``k``; what is out of range shows as an empty road."""
    length, reach, limit = c[layout.LENGTH], c[layout.FRONT_RANGE], c[layout.SPEED_LIMIT]
    line_range = c[layout.LINE_RANGE]
    for i in range(low, high):
        measured[layout.V_E, k, i] = state[layout.SPEED, k, i]
        measured[layout.A_E, k, i] = state[layout.ACCEL, k, i]
        measured[layout.J_E, k, i] = state[layout.JERK, k, i]
    for i in range(low, high):
        x = state[layout.POSITION, k, i]
        d_f = state[layout.POSITION, k + 1, i] - length - x
        seen = d_f <= reach
        measured[layout.D_F, k, i] = max(d_f, 0.0) if seen else reach
        measured[layout.V_F, k, i] = state[layout.SPEED, k + 1, i] if seen else limit
        measured[layout.A_F, k, i] = state[layout.ACCEL, k + 1, i] if seen else 0.0
        measured[layout.D_D, k, i] = min(state[layout.LINE, k, i] - x, line_range)


@kernel
def derive(measured: Floats, k: int, c: Floats, low: int, high: int) -> None:
    """Write d_fc, d_dc and their ratios, clipped to [-1, 10], from the base quantities of agent ``k``: Eq. (dis)."""
    per_twice_decel, safe_gap = c[layout.PER_TWICE_DECEL], c[layout.SAFE_GAP]
    for i in range(low, high):
        v_e, v_f = measured[layout.V_E, k, i], measured[layout.V_F, k, i]
        d_fs = max((v_e * v_e - v_f * v_f) * per_twice_decel, safe_gap)
        d_fc = measured[layout.D_F, k, i] - d_fs
        measured[layout.D_FC, k, i] = d_fc
        measured[layout.FC_RATIO, k, i] = min(max(d_fc / d_fs, RATIO_LOW), RATIO_HIGH)
    for i in range(low, high):
        v_e = measured[layout.V_E, k, i]
        d_ds = v_e * v_e * per_twice_decel
        d_dc = measured[layout.D_D, k, i] - d_ds
        measured[layout.D_DC, k, i] = d_dc
        measured[layout.DC_RATIO, k, i] = min(max(d_dc / max(d_ds, MIN_STOPPING_DISTANCE), RATIO_LOW), RATIO_HIGH)


@kernel
def noise_scale(field: int, c: Floats) -> float:
    """Return the standard deviation of the noise on one base quantity; the ego knows its own jerk exactly."""
    if field in (layout.V_E, layout.V_F):
        return float(c[layout.NOISE_SPEED])
    if field in (layout.A_E, layout.A_F):
        return float(c[layout.NOISE_ACCEL])
    if field in (layout.D_F, layout.D_D):
        return float(c[layout.NOISE_DISTANCE])
    return 0.0


@kernel
def perturb(measured: Floats, history: Floats, steps: Ints, keys: Keys, k: int, c: Floats, low: int, high: int) -> None:
    """Replace the base quantities of agent ``k`` by delayed and noisy ones, and derive the others from them.

    ``history``, float64 [DELAY + 1, BASE_SIZE, agent, row], is a ring of the last base quantities; before there are
    enough, the first ones are shown. Noise is keyed by (seed, episode, agent, step, channel), so it does not depend on
    the batch.
    """
    size = history.shape[0]
    for i in range(low, high):
        step = steps[i]
        shown = max(step - (size - 1), 0) % size
        for field in range(layout.BASE_SIZE):
            history[step % size, field, k, i] = measured[field, k, i]
            key = stream(keys[0, i], keys[1, i], k, NOISE + step)
            value = history[shown, field, k, i] + noise_scale(field, c) * normal(key, field)
            positive = field in (layout.V_E, layout.V_F, layout.D_F)
            measured[field, k, i] = max(value, 0.0) if positive else value
    derive(measured, k, c, low, high)
