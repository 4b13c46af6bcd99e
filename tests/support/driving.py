"""Ways to drive that the tests share."""

import numpy as np
from numpy.typing import NDArray

from hhrl_envs import Simulator, observation


def random_actions(seed: int, steps: int, rows: int, levels: int) -> NDArray[np.int64]:
    """Actions [steps, rows] that are held for a while, so that vehicles get somewhere."""
    rng = np.random.default_rng(seed)
    fresh = rng.integers(0, levels, (steps, rows))
    keep = rng.random((steps, rows)) < 0.9
    for t in range(1, steps):
        fresh[t] = np.where(keep[t], fresh[t - 1], fresh[t])
    return fresh


def careful_actions(simulator: Simulator) -> NDArray[np.int64]:
    """A driver who mostly reaches the line: brakes for whatever is nearest, else rolls on at walking pace or faster."""
    si = observation.to_si(simulator.observations)
    room = np.minimum(si[:, observation.D_D] - 1.0, si[:, observation.D_F] - 6.0)
    wanted = np.sqrt(np.maximum(2.0 * 1.5 * room, 0.0))
    target = np.clip((wanted - si[:, observation.V_E]) / 0.5, -6.0, 2.0)
    levels = np.array(simulator.scenario.vehicle.levels)
    nearest: NDArray[np.int64] = np.abs(levels[None, :] - target[:, None]).argmin(axis=1)
    return nearest
