"""What an agent can measure: the base quantities of the state, and Eq. (dis) computed from them."""

from hhrl_envs import layout as at
from hhrl_envs.compiled import Floats, Keys, inner, unsigned
from hhrl_envs.streams import normal, stream

MIN_STOPPING_DISTANCE = 0.5  # m; floor of d_ds where it is a denominator
RATIO_LOW, RATIO_HIGH = -1.0, 10.0
NOISE = 7  # purpose of the noise streams
# Among the measured quantities: those that the others derive from, and those that share a kind of noise or a sign.
BASE = (0, 1, 2, 3, 4, 5, 8)
SPEEDS, ACCELERATIONS, DISTANCES, POSITIVE = (0, 4), (1, 5), (3, 8), (0, 3, 4)


@inner
def distances(v_e: float, d_f: float, v_f: float, d_d: float, c: Floats) -> tuple[float, float, float, float]:
    """Return d_fc, d_fc/d_fs, d_dc and d_dc/d_ds, the ratios clipped to [-1, 10]: Eq. (dis)."""
    d_fs = max((v_e * v_e - v_f * v_f) * c[at.PER_TWICE_DECEL], c[at.SAFE_GAP])
    d_fc = d_f - d_fs
    d_ds = v_e * v_e * c[at.PER_TWICE_DECEL]
    d_dc = d_d - d_ds
    fc_ratio = min(max(d_fc / d_fs, RATIO_LOW), RATIO_HIGH)
    return d_fc, fc_ratio, d_dc, min(max(d_dc / max(d_ds, MIN_STOPPING_DISTANCE), RATIO_LOW), RATIO_HIGH)


@inner
def measure(m: Floats, s: int, a: int, c: Floats, lanes: int) -> None:
    """Write what the agents of record ``a`` measure, truthfully; what is out of range shows as an empty road."""
    length, reach, limit = c[at.LENGTH], c[at.FRONT_RANGE], c[at.SPEED_LIMIT]
    line_range, leader = c[at.LINE_RANGE], s + at.VEHICLE
    for i in range(lanes):
        x, v_e = m[s + at.POSITION + i], m[s + at.SPEED + i]
        ahead = m[leader + at.POSITION + i] - length - x
        seen = ahead <= reach
        d_f, v_f = max(ahead, 0.0) if seen else reach, m[leader + at.SPEED + i] if seen else limit
        d_d = min(m[s + at.LINE + i] - x, line_range)
        d_fc, fc_ratio, d_dc, dc_ratio = distances(v_e, d_f, v_f, d_d, c)
        m[a + at.V_E + i] = v_e
        m[a + at.A_E + i] = m[s + at.ACCEL + i]
        m[a + at.J_E + i] = m[s + at.JERK + i]
        m[a + at.D_F + i] = d_f
        m[a + at.V_F + i] = v_f
        m[a + at.A_F + i] = m[leader + at.ACCEL + i] if seen else 0.0
        m[a + at.D_D + i] = d_d
        m[a + at.D_FC + i] = d_fc
        m[a + at.FC_RATIO + i] = fc_ratio
        m[a + at.D_DC + i] = d_dc
        m[a + at.DC_RATIO + i] = dc_ratio


@inner
def noise_scale(quantity: int, c: Floats) -> float:
    """Return the standard deviation of the noise on one base quantity; an agent knows its own jerk exactly."""
    if quantity in SPEEDS:
        return float(c[at.NOISE_SPEED])
    if quantity in ACCELERATIONS:
        return float(c[at.NOISE_ACCEL])
    if quantity in DISTANCES:
        return float(c[at.NOISE_DISTANCE])
    return 0.0


@inner
def blur(m: Floats, a: int, history: Floats, keys: Keys, agent: int, step: int, row: int, c: Floats) -> None:
    """Replace the base quantities of one agent by delayed and noisy ones, and derive the others from them.

    ``a`` is the agent's record plus its lane. ``history``, float64 [delay + 1, channel, agent, row], is a ring of
    the last base quantities; before there are enough, the first ones are shown. Noise is keyed by (seed, episode,
    agent, step, channel), so it does not depend on the batch.
    """
    size = history.shape[0]
    shown = max(step - (size - 1), 0) % size
    key = stream(keys[0, row], keys[1, row], unsigned(agent), unsigned(NOISE + step))
    for channel in range(len(BASE)):
        quantity = BASE[channel]
        place = a + at.MEASURED + unsigned(quantity * at.STRIDE)
        history[step % size, channel, agent, row] = m[place]
        value = history[shown, channel, agent, row] + noise_scale(quantity, c) * normal(key, channel)
        m[place] = max(value, 0.0) if quantity in POSITIVE else value
    d_fc, fc_ratio, d_dc, dc_ratio = distances(m[a + at.V_E], m[a + at.D_F], m[a + at.V_F], m[a + at.D_D], c)
    m[a + at.D_FC], m[a + at.FC_RATIO] = d_fc, fc_ratio
    m[a + at.D_DC], m[a + at.DC_RATIO] = d_dc, dc_ratio
