"""The 11-element state of Eq. (state), as the agents see it; ``sub_goals`` declares its elements.

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
| 8 | d_d | m | 1/64 | up to 100 m | distance to the active stop-line, negative past it; 100 m if there is none |
| 9 | d_dc | m | 1/64 | - | d_d - d_ds, with d_ds = v_e^2 / (2 a_max) |
| 10 | d_dc/d_ds | 1 | 1/4 | [-1, 10] | the same as a share of the stopping distance, floored at 0.5 m |

An observation is the SI value times its scale, float32. The scales are powers of two, so that dividing by them gives
back the float32 SI value exactly.
"""

import numpy as np

from hhrl_envs.arrays import Floats32
from hhrl_envs.sub_goals import EGO_ELEMENTS, STATE_ORDER

ELEMENTS = EGO_ELEMENTS + tuple(element for goal in STATE_ORDER for element in goal.elements)
"""The elements of the state in their order."""

SIZE = len(ELEMENTS)
SYMBOLS = tuple(element.symbol for element in ELEMENTS)
UNITS = tuple(element.unit for element in ELEMENTS)
SCALES: Floats32 = np.array([element.scale for element in ELEMENTS], np.float32)


def place(symbol: str) -> int:
    """Return the index of the element with a symbol, such as ``"d_f"``."""
    return SYMBOLS.index(symbol)


V_E, A_E, J_E = map(place, ("v_e", "a_e", "j_e"))
D_F, V_F, A_F, D_FC, FC_RATIO = map(place, ("d_f", "v_f", "a_f", "d_fc", "d_fc/d_fs"))
D_D, D_DC, DC_RATIO = map(place, ("d_d", "d_dc", "d_dc/d_ds"))


def to_si(observations: Floats32) -> Floats32:
    """Return the SI values of scaled observations, float32 of the same shape [..., SIZE]."""
    return observations / SCALES
