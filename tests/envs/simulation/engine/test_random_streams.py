import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from support.draws import between, stream, unit

SEEDS = st.integers(0, 2**64 - 1)


def key_of(seed: int, episode: int, vehicle: int, purpose: int) -> np.uint64:
    return np.uint64(stream(np.uint64(seed), episode, vehicle, purpose))


@settings(deadline=None)  # the first example compiles
@given(SEEDS, st.integers(0, 2**32), st.integers(0, 10), st.integers(0, 10))
def test_a_draw_depends_on_its_key_alone(seed: int, episode: int, vehicle: int, purpose: int) -> None:
    key = key_of(seed, episode, vehicle, purpose)
    later = unit(key, 7)
    assert unit(key, 3) == unit(key_of(seed, episode, vehicle, purpose), 3)
    assert unit(key, 7) == later
    assert 0.0 <= later < 1.0


def test_neighbouring_keys_are_uncorrelated_and_uniform() -> None:
    draws = np.array([[unit(key_of(s, e, v, 1), 0) for v in range(4)] for s in range(40) for e in range(40)])
    assert np.abs(np.corrcoef(draws.T) - np.eye(4)).max() < 0.1
    assert np.abs(np.diff(draws, axis=0)).min() > 0.0
    counts = np.histogram(draws, bins=16, range=(0, 1))[0]
    expected = draws.size / 16
    assert ((counts - expected) ** 2 / expected).sum() < 37.7  # chi-square, 15 degrees of freedom, p = 0.001


@settings(deadline=None)
@given(SEEDS, st.floats(-100, 100), st.floats(0, 100))
def test_between_stays_in_its_range(seed: int, low: float, width: float) -> None:
    assert low <= between(key_of(seed, 0, 0, 0), 0, low, low + width) <= low + width
