"""Imperfect sensors: what the agents see is a delayed and noisy version of the truth."""

from hhrl_envs import layout as at
from hhrl_envs.blocks import locate_row
from hhrl_envs.compiled import Floats, Floats32, Keys, kernel, unsigned
from hhrl_envs.observation import observe
from hhrl_envs.sensing import blur, measure


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
