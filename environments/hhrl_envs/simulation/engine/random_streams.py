"""Counter-based random streams: a draw is a pure function of its key, so it never depends on what was drawn before.

The key is (seed, episode, vehicle, purpose); each part is absorbed by one round of the SplitMix64 finaliser (Steele,
Lea and Flood 2014), whose output is uniform on 64 bits. Nothing here or above it touches numba's or numpy's global
generators.
"""

import numpy as np

from hhrl_envs.simulation.engine.compilation import inner, unsigned

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX_2 = np.uint64(0x94D049BB133111EB)
_S30, _S27, _S31, _S11 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)
_TO_UNIT = 1.0 / 9007199254740992.0  # 2**-53


@inner
def absorb(key: np.uint64, part: np.uint64) -> np.uint64:
    """Return the 64-bit key that follows ``key`` when ``part`` is absorbed."""
    z = (key ^ part) + _GOLDEN
    z = (z ^ (z >> _S30)) * _MIX_1
    z = (z ^ (z >> _S27)) * _MIX_2
    return z ^ (z >> _S31)


@inner
def stream(seed: np.uint64 | int, episode: np.uint64 | int, vehicle: int, purpose: int) -> np.uint64:
    """Return the 64-bit key of one named stream."""
    key = absorb(absorb(_GOLDEN, np.uint64(seed)), np.uint64(episode))
    return absorb(absorb(key, np.uint64(vehicle)), np.uint64(purpose))


@inner
def unit(key: np.uint64, index: int) -> float:
    """Return draw ``index`` of a stream, uniform in [0, 1)."""
    return np.float64(absorb(key, np.uint64(index)) >> _S11) * _TO_UNIT


@inner
def between(key: np.uint64, index: int, low: float, high: float) -> float:
    """Return draw ``index`` of a stream, uniform in [low, high)."""
    return low + (high - low) * unit(key, index)


@inner
def normal(key: np.uint64, index: int) -> float:
    """Return draw ``index`` of a stream, nearly standard normal: the sum of twelve uniforms less six, so within +-6."""
    total = -6.0
    for part in range(12):
        total += unit(key, unsigned(12 * index + part))
    return total
