import numpy as np

from hhrl_agents.seeding import Purpose, generator, restore_stream, save_stream


def test_generators_are_a_function_of_seed_and_purpose() -> None:
    first, second = generator(7, Purpose.REPLAY), generator(7, Purpose.REPLAY)
    generator(2, Purpose.REPLAY).random(3)
    np.testing.assert_array_equal(first.random(15), second.random(15))


def test_seeds_and_purposes_have_streams_of_their_own() -> None:
    streams = [generator(seed, purpose) for seed in (0, 1, 2) for purpose in Purpose]
    assert len({stream.random() for stream in streams}) == len(streams)


def test_draws_are_uniform() -> None:
    for seed in range(4):
        drawn = generator(seed, Purpose.EXPLORATION).random(5000)
        assert drawn.min() >= 0.0
        assert drawn.max() < 1.0
        assert np.abs(np.histogram(drawn, 10, (0, 1))[0] - 500).max() < 5 * np.sqrt(500)


def test_a_restored_stream_goes_on_where_the_saved_one_was() -> None:
    """With half a word in its buffer, which a permutation may leave there."""
    stream, other = generator(5, Purpose.SHUFFLING), generator(6, Purpose.SHUFFLING)
    stream.integers(0, 9, dtype=np.uint32)
    saved = save_stream(stream)
    expected = stream.permutation(50), stream.random(4)
    restore_stream(other, saved)
    for array, same in zip(expected, (other.permutation(50), other.random(4)), strict=True):
        np.testing.assert_array_equal(array, same)
