"""Which of several points nobody beats: lower is better in every coordinate."""

import numpy as np
from numpy.typing import NDArray

from hhrl_bench.statistics import FloatArray


def non_dominated(points: FloatArray) -> NDArray[np.bool_]:
    """Return which of the points [n, k] no other one is at most equal to in all coordinates and below in one, [n]."""
    no_worse = (points[:, None] <= points).all(axis=-1)
    better = (points[:, None] < points).any(axis=-1)
    dominated: NDArray[np.bool_] = np.any(no_worse & better, axis=0)
    return ~dominated
