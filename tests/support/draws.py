"""The random streams as Python may call them: they are made to be parts of kernels."""

import numpy as np

from hhrl_envs.simulation.engine import random_streams
from hhrl_envs.simulation.engine.compilation import kernel, unsigned


@kernel
def stream(seed: np.uint64, episode: int, vehicle: int, purpose: int) -> np.uint64:
    return random_streams.stream(seed, unsigned(episode), unsigned(vehicle), unsigned(purpose))


@kernel
def unit(key: np.uint64, index: int) -> float:
    return random_streams.unit(key, unsigned(index))


@kernel
def between(key: np.uint64, index: int, low: float, high: float) -> float:
    return random_streams.between(key, unsigned(index), low, high)
