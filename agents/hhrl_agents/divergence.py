"""Divergence: values that no sum of discounted rewards can reach."""

from collections.abc import Mapping

import numpy as np
from torch import Tensor

from hhrl_agents.base import FloatArray


def beyond_bound(values: Mapping[str, Tensor], largest_reward: FloatArray, gamma: float) -> dict[int, str]:
    """Return the seeds whose values lie beyond max |r| / (1 - gamma), each with the reason in words.

    values: level -> values of a mini-batch, [E, C, M]; largest_reward: max |r| of each seed, float64 [E].
    """
    with np.errstate(divide="ignore"):
        bound = largest_reward / np.float64(1.0 - gamma)
    reached = {level: value.abs().amax((1, 2)).cpu().double().numpy() for level, value in values.items()}
    return {
        int(index): f"its {level} values reach {largest[index]:.3g}, the rewards allow {bound[index]:.3g}"
        for level, largest in reached.items()
        for index in np.flatnonzero(largest > bound)
    }
