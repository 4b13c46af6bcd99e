import numpy as np

from hhrl_agents.seeding import Purpose, generators, uniforms


def test_a_seed_draws_the_same_whoever_is_stacked_with_it() -> None:
    alone = uniforms(generators([7], Purpose.REPLAY), 3, 5)
    stacked = uniforms(generators([2, 7, 9], Purpose.REPLAY), 3, 5)
    np.testing.assert_array_equal(stacked[1], alone[0])


def test_seeds_and_purposes_have_streams_of_their_own() -> None:
    streams = [generators([seed], purpose) for seed in (0, 1, 2) for purpose in Purpose]
    firsts = {float(uniforms(stream, 1)[0, 0]) for stream in streams}
    assert len(firsts) == len(streams)


def test_draws_are_uniform() -> None:
    drawn = uniforms(generators(range(4), Purpose.EXPLORATION), 5000)
    assert drawn.min() >= 0.0
    assert drawn.max() < 1.0
    counts = np.apply_along_axis(lambda row: np.histogram(row, 10, (0, 1))[0], 1, drawn)
    assert np.abs(counts - 500).max() < 5 * np.sqrt(500)
