"""The 11-element state of Eq. (state), as the agents see it.

| index | symbol | unit | scale | clip | meaning |
|---|---|---|---|---|---|
| 0 | v_e | m/s | 1/16 | - | speed of the ego |
| 1 | a_e | m/s^2 | 1/8 | - | acceleration of the ego |
| 2 | j_e | m/s^3 | 1/64 | - | jerk of the ego |
| 3 | d_f | m | 1/64 | [0, sensor range] | free road to the front vehicle's rear bumper |
| 4 | v_f | m/s | 1/16 | - | speed of the front vehicle; the speed limit if none is in range |
| 5 | a_f | m/s^2 | 1/8 | - | acceleration of the front vehicle; 0 if none is in range |
| 6 | d_fc | m | 1/64 | - | d_f - d_fs, with d_fs = max((v_e^2 - v_f^2) / (2 a_max), d_0) |
| 7 | d_fc/d_fs | 1 | 1/4 | [-1, 10] | the same as a share of the safety distance |
| 8 | d_d | m | 1/64 | - | distance to the stop-line, negative past it |
| 9 | d_dc | m | 1/64 | - | d_d - d_ds, with d_ds = v_e^2 / (2 a_max) |
| 10 | d_dc/d_ds | 1 | 1/4 | [-1, 10] | the same as a share of the stopping distance, floored at 0.5 m |

An observation is the SI value times its scale, float32. The scales are powers of two, so that dividing by them gives
back the float32 SI value exactly.
"""

import numpy as np

from hhrl_envs import layout
from hhrl_envs.compiled import Floats, Floats32, kernel

V_E, A_E, J_E, D_F, V_F, A_F, D_FC, FC_RATIO, D_D, D_DC, DC_RATIO = range(11)
SIZE = 11
SYMBOLS = ("v_e", "a_e", "j_e", "d_f", "v_f", "a_f", "d_fc", "d_fc/d_fs", "d_d", "d_dc", "d_dc/d_ds")
UNITS = ("m/s", "m/s^2", "m/s^3", "m", "m/s", "m/s^2", "m", "1", "m", "m", "1")

_SPEED, _ACCEL, _JERK, _DISTANCE, _RATIO = 1 / 16, 1 / 8, 1 / 64, 1 / 64, 1 / 4
SCALES: Floats32 = np.array(
    [_SPEED, _ACCEL, _JERK, _DISTANCE, _SPEED, _ACCEL, _DISTANCE, _RATIO, _DISTANCE, _DISTANCE, _RATIO], np.float32
)
RATIO_LOW, RATIO_HIGH = -1.0, 10.0
MIN_STOPPING_DISTANCE = 0.5  # m; floor of d_ds where it is a denominator


def to_si(observations: Floats32) -> Floats32:
    """Return the SI values of scaled observations, float32 of the same shape [..., 11]."""
    return observations / SCALES


@kernel
def safety_distance(v_e: float, v_f: float, c: Floats) -> float:
    """Return d_fs of Eq. (dis) in metres."""
    return max((v_e * v_e - v_f * v_f) / (2.0 * float(c[layout.NOMINAL_DECEL])), float(c[layout.SAFE_GAP]))


@kernel
def stopping_distance(v_e: float, c: Floats) -> float:
    """Return d_ds of Eq. (dis) in metres."""
    return v_e * v_e / (2.0 * float(c[layout.NOMINAL_DECEL]))


@kernel
def clipped_ratio(distance: float, reference: float) -> float:
    """Return ``distance / reference`` clipped to [-1, 10]."""
    return min(max(distance / reference, RATIO_LOW), RATIO_HIGH)


@kernel
def observe(state: Floats, out: Floats32, c: Floats, rows: int) -> None:
    """Write the observations of the first ``rows`` rows into ``out``, float32 [11, B]."""
    length, sensor, limit = c[layout.LENGTH], c[layout.SENSOR_RANGE], c[layout.SPEED_LIMIT]
    for i in range(rows):
        v_e = state[layout.SPEED, 0, i]
        out[V_E, i] = v_e * _SPEED
        out[A_E, i] = state[layout.ACCEL, 0, i] * _ACCEL
        out[J_E, i] = state[layout.JERK, 0, i] * _JERK
    for i in range(rows):
        v_e = state[layout.SPEED, 0, i]
        gap = state[layout.POSITION, 1, i] - length - state[layout.POSITION, 0, i]
        seen = gap <= sensor
        d_f = max(gap, 0.0) if seen else sensor
        v_f = state[layout.SPEED, 1, i] if seen else limit
        d_fs = safety_distance(v_e, v_f, c)
        out[D_F, i] = d_f * _DISTANCE
        out[V_F, i] = v_f * _SPEED
        out[A_F, i] = (state[layout.ACCEL, 1, i] if seen else 0.0) * _ACCEL
        out[D_FC, i] = (d_f - d_fs) * _DISTANCE
        out[FC_RATIO, i] = clipped_ratio(d_f - d_fs, d_fs) * _RATIO
    for i in range(rows):
        v_e = state[layout.SPEED, 0, i]
        d_d = -state[layout.POSITION, 0, i]
        d_ds = stopping_distance(v_e, c)
        out[D_D, i] = d_d * _DISTANCE
        out[D_DC, i] = (d_d - d_ds) * _DISTANCE
        out[DC_RATIO, i] = clipped_ratio(d_d - d_ds, max(d_ds, MIN_STOPPING_DISTANCE)) * _RATIO
