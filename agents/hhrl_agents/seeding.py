"""Random streams of one seed: each purpose has its own, and none depends on which seeds are trained beside it."""

from collections.abc import Sequence
from enum import IntEnum

import numpy as np

from hhrl_agents.base import FloatArray


class Purpose(IntEnum):
    """What a stream of random numbers is used for."""

    INITIALISATION = 0
    EXPLORATION = 1
    REPLAY = 2
    SHUFFLING = 3


def generators(seeds: Sequence[int], purpose: Purpose) -> list[np.random.Generator]:
    """Return one PCG64 generator for each seed, a pure function of (seed, purpose)."""
    return [np.random.Generator(np.random.PCG64(np.random.SeedSequence((seed, purpose)))) for seed in seeds]


def uniforms(streams: Sequence[np.random.Generator], *shape: int) -> FloatArray:
    """Return numbers uniform in [0, 1), float64 [E, *shape], row e drawn from stream e alone."""
    drawn = np.empty((len(streams), *shape))
    for row, stream in zip(drawn, streams, strict=True):
        stream.random(out=row)
    return drawn
