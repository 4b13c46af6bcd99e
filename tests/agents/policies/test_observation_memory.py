"""Running averages of the observations, row by row."""

import numpy as np
import pytest
from numpy.typing import NDArray

from hhrl_agents.policies.observation_memory import Traces
from hhrl_envs import InputError
from hhrl_envs.observation import SIZE

RATES = (0.5, 0.1, 0.03)
ROWS, STEPS = 5, 30
Array = NDArray[np.float32]
Mask = NDArray[np.bool_]


def played(seed: int = 0) -> tuple[Array, Mask, Mask]:
    """Observations [T, B, 11], which rows begin an episode before, and which are observed, bool [T, B] each."""
    rng = np.random.default_rng(seed)
    begins, seen = rng.random((STEPS, ROWS)) < 0.1, rng.random((STEPS, ROWS)) < 0.7
    begins[0] = True
    return rng.normal(size=(STEPS, ROWS, SIZE)).astype(np.float32), begins, seen


def plain(observations: Array, begins: Mask, seen: Mask) -> Array:
    """The features of one row, [T, 11 (1 + rates)], by a loop over time and rates; NaN for a trace not yet begun."""
    traces: list[Array | None] = [None] * len(RATES)
    features = []
    for observation, begin, is_seen in zip(observations, begins, seen, strict=True):
        for index, rate in enumerate(RATES):
            before = None if begin else traces[index]
            if is_seen:
                moved = observation if before is None else before + np.float32(rate) * (observation - before)
                traces[index] = moved.astype(np.float32)
            else:
                traces[index] = before
        known = [np.full(SIZE, np.nan, np.float32) if trace is None else trace for trace in traces]
        features.append(np.concatenate([observation, *known]))
    return np.array(features, np.float32)


def test_traces_are_those_of_a_plain_loop() -> None:
    (observations, begins, _), memory = played(), Traces(RATES)
    everywhere = np.ones((STEPS, ROWS), np.bool_)
    for step in range(STEPS):
        memory.begin(begins[step])
        features = memory.observe(observations[step])
        assert features.shape == (ROWS, SIZE * (1 + len(RATES)))
        assert features.dtype == np.float32
        for row in range(ROWS):
            expected = plain(observations[: step + 1, row], begins[: step + 1, row], everywhere[: step + 1, row])[-1]
            np.testing.assert_allclose(features[row], expected, rtol=1e-5, atol=1e-6)


def test_rows_that_are_not_observed_keep_their_traces() -> None:
    (observations, begins, seen), memory = played(), Traces(RATES)
    expected = np.stack([plain(observations[:, row], begins[:, row], seen[:, row]) for row in range(ROWS)], 1)
    compared = 0
    for step in range(STEPS):
        memory.begin(begins[step])
        features = memory.observe(observations[step], seen[step])
        known = ~np.isnan(expected[step]).any(1)
        np.testing.assert_allclose(features[known], expected[step][known], rtol=1e-5, atol=1e-6)
        compared += int((known & ~seen[step]).sum())
    assert compared > 10


def test_a_row_s_traces_do_not_depend_on_the_others() -> None:
    (observations, begins, _), together, alone = played(), Traces(RATES), Traces(RATES)
    others, begins_of_others, _ = played(7)
    others[:, 2], begins_of_others[:, 2] = observations[:, 2], begins[:, 2]
    for step in range(STEPS):
        together.begin(begins[step])
        alone.begin(begins_of_others[step, 2:3])
        features = together.observe(observations[step])
        np.testing.assert_array_equal(features[2], alone.observe(others[step, 2:3])[0])


def test_an_episode_begins_at_its_first_observation() -> None:
    (observations, _, _), memory = played(), Traces(RATES)
    for step in range(3):
        memory.observe(observations[step])
    memory.begin(np.arange(ROWS) == 3)
    features = memory.observe(observations[4]).reshape(ROWS, 1 + len(RATES), SIZE)
    first = np.broadcast_to(features[3, 0], features[3].shape)
    np.testing.assert_allclose(features[3], first, rtol=1e-6, atol=1e-6)
    for row in (0, 1, 2, 4):
        assert (np.abs(features[row, 1:] - features[row, :1]) > 1e-3).any()


def test_without_rates_there_are_the_observations_alone() -> None:
    (observations, begins, seen), memory = played(), Traces(())
    memory.begin(begins[0])
    np.testing.assert_array_equal(memory.observe(observations[0]), observations[0])
    np.testing.assert_array_equal(memory.observe(observations[1], seen[1]), observations[1])


def test_rows_that_nobody_announced_begin_by_themselves() -> None:
    (observations, _, _), memory, told = played(), Traces(RATES), Traces(RATES)
    told.begin(np.ones(ROWS, np.bool_))
    np.testing.assert_array_equal(memory.observe(observations[0]), told.observe(observations[0]))


def test_another_number_of_rows_begins_anew() -> None:
    (observations, _, _), memory = played(), Traces(RATES)
    memory.observe(observations[0])
    fewer = memory.observe(observations[1, :3])
    np.testing.assert_array_equal(fewer, Traces(RATES).observe(observations[1, :3]))
    memory.begin(np.zeros(ROWS, np.bool_))
    more = memory.observe(observations[2])
    np.testing.assert_array_equal(more, Traces(RATES).observe(observations[2]))


def test_what_is_returned_stays_as_it_is() -> None:
    (observations, _, _), memory = played(), Traces(RATES)
    first = memory.observe(observations[0])
    kept, given = first.copy(), observations[0].copy()
    memory.observe(observations[1])
    np.testing.assert_array_equal(first, kept)
    np.testing.assert_array_equal(observations[0], given)


def test_a_restored_memory_goes_on_to_the_same_bits() -> None:
    (observations, begins, seen), memory, fresh = played(), Traces(RATES), Traces(RATES)
    fresh.begin(begins[0])
    for step in range(STEPS):
        memory.begin(begins[step])
        if step == STEPS // 2:
            saved = memory.state()
            kept = {name: array.copy() for name, array in saved.items()}
            fresh.restore(saved)
        features = memory.observe(observations[step], seen[step])
        if step >= STEPS // 2:
            fresh.begin(begins[step])
            np.testing.assert_array_equal(fresh.observe(observations[step], seen[step]), features)
    assert all(np.array_equal(saved[name], array) for name, array in kept.items())


def test_the_state_of_another_memory_is_refused() -> None:
    memory, other = Traces(RATES), Traces(RATES[:2])
    for traces in (memory, other):
        traces.begin(np.ones(ROWS, np.bool_))
    with pytest.raises(InputError, match="'traces'"):
        memory.restore(other.state())
