"""What an agent can measure: the base quantities of the state, and Eq. (dis) computed from them."""

from hhrl_envs.arrays import Floats, Floats32, Keys
from hhrl_envs.observation import _SCALES
from hhrl_envs.simulation.engine import layout as at
from hhrl_envs.simulation.engine.compilation import inner, kernel, unsigned
from hhrl_envs.simulation.engine.layout import locate_row
from hhrl_envs.simulation.engine.random_streams import normal, stream

MIN_STOPPING_DISTANCE = 0.5  # m; floor of d_ds where it is a denominator
RATIO_LOW, RATIO_HIGH = -1.0, 10.0
NOISE = 7  # purpose of the noise streams
# Among the measured quantities: those that the others derive from, and those that share a kind of noise or a sign.
BASE = (0, 1, 2, 3, 4, 5, 8)
SPEEDS, ACCELERATIONS, DISTANCES, POSITIVE = (0, 4), (1, 5), (3, 8), (0, 3, 4)


@inner
def distances(
    v_e: float, d_f: float, v_f: float, d_d: float, per_twice_decel: float, safe_gap: float
) -> tuple[float, float, float, float]:
    """Return d_fc, d_fc/d_fs, d_dc and d_dc/d_ds, the ratios clipped to [-1, 10]: Eq. (dis)."""
    d_fs = max((v_e * v_e - v_f * v_f) * per_twice_decel, safe_gap)
    d_fc = d_f - d_fs
    d_ds = v_e * v_e * per_twice_decel
    d_dc = d_d - d_ds
    fc_ratio = min(max(d_fc / d_fs, RATIO_LOW), RATIO_HIGH)
    return d_fc, fc_ratio, d_dc, min(max(d_dc / max(d_ds, MIN_STOPPING_DISTANCE), RATIO_LOW), RATIO_HIGH)


@inner
def measure(m: Floats, s: int, c: Floats, lanes: int) -> None:
    """Write what the agents of record ``s`` measure, truthfully; what is out of range shows as an empty road."""
    length, reach, limit = c[at.LENGTH], c[at.FRONT_RANGE], c[at.SPEED_LIMIT]
    line_range, leader = c[at.LINE_RANGE], s + at.VEHICLE
    per_twice_decel, safe_gap = c[at.PER_TWICE_DECEL], c[at.SAFE_GAP]
    for i in range(lanes):
        x, v_e = m[s + at.POSITION + i], m[s + at.SPEED + i]
        ahead, v_f, a_f = m[leader + at.POSITION + i] - length - x, m[leader + at.SPEED + i], m[leader + at.ACCEL + i]
        seen = ahead <= reach
        d_f, v_f, a_f = min(max(ahead, 0.0), reach), v_f if seen else limit, a_f if seen else 0.0
        d_d = min(m[s + at.LINE + i] - x, line_range)
        d_fc, fc_ratio, d_dc, dc_ratio = distances(v_e, d_f, v_f, d_d, per_twice_decel, safe_gap)
        m[s + at.V_E + i] = v_e
        m[s + at.A_E + i] = m[s + at.ACCEL + i]
        m[s + at.J_E + i] = m[s + at.JERK + i]
        m[s + at.D_F + i] = d_f
        m[s + at.V_F + i] = v_f
        m[s + at.A_F + i] = a_f
        m[s + at.D_D + i] = d_d
        m[s + at.D_FC + i] = d_fc
        m[s + at.FC_RATIO + i] = fc_ratio
        m[s + at.D_DC + i] = d_dc
        m[s + at.DC_RATIO + i] = dc_ratio


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
def blur(m: Floats, s: int, history: Floats, keys: Keys, agent: int, step: int, row: int, c: Floats) -> None:
    """Replace the base quantities of one agent by delayed and noisy ones, and derive the others from them.

    ``s`` is the agent's record plus its lane. ``history``, float64 [delay + 1, channel, agent, row], is a ring of
    the last base quantities; before there are enough, the first ones are shown. Noise is keyed by (seed, episode,
    agent, step, channel), so it does not depend on the batch.
    """
    size = history.shape[0]
    shown = max(step - (size - 1), 0) % size
    key = stream(keys[0, row], keys[1, row], unsigned(agent), unsigned(NOISE + step))
    for channel in range(len(BASE)):
        quantity = BASE[channel]
        place = s + at.MEASURED + unsigned(quantity * at.STRIDE)
        history[step % size, channel, agent, row] = m[place]
        value = history[shown, channel, agent, row] + noise_scale(quantity, c) * normal(key, channel)
        m[place] = max(value, 0.0) if quantity in POSITIVE else value
    d_fc, fc_ratio, d_dc, dc_ratio = distances(
        m[s + at.V_E], m[s + at.D_F], m[s + at.V_F], m[s + at.D_D], c[at.PER_TWICE_DECEL], c[at.SAFE_GAP]
    )
    m[s + at.D_FC], m[s + at.FC_RATIO] = d_fc, fc_ratio
    m[s + at.D_DC], m[s + at.DC_RATIO] = d_dc, dc_ratio


@kernel
def blur_rows(
    m: Floats, c: Floats, observations: Floats32, keys: Keys, history: Floats, rows: int, low: int, high: int
) -> None:
    """Write the observations of the blocks from low to high as the sensors see them.

    ``history``, float64 [delay + 1, channel, agent, row], remembers the last measurements.
    """
    for row in range(low * at.LANES, min(high * at.LANES, rows)):
        s, r = locate_row(row, c)
        step = int(m[r + at.STEPS])
        for agent in range(observations.shape[1]):
            measure(m, s, c, unsigned(1))
            blur(m, s, history, keys, agent, step, row, c)
            observe(m, s, observations, agent, unsigned(row), unsigned(1))
            s += at.VEHICLE


@inner
def observe(m: Floats, s: int, out: Floats32, agent: int, first: int, lanes: int) -> None:
    """Write the observations of the agents of record ``s`` to ``out``, float32 [11, agent, row], from row ``first``."""
    for index in range(out.shape[0]):
        measured, scale = s + at.MEASURED + unsigned(index * at.STRIDE), _SCALES[index]
        for i in range(lanes):
            out[index, agent, first + i] = m[measured + i] * scale
