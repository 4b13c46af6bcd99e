from typing import NamedTuple

import numpy as np
import pytest

from hhrl_agents.replay.buffer import Transitions
from hhrl_agents.replay.n_step import MultiStep
from hhrl_envs.arrays import Flags
from hhrl_envs.observation import SIZE

GAMMA = 0.9
STEPS, N_ENVS = 40, 6
RUNNING, TERMINAL, TRUNCATED = range(3)


class Episodes(NamedTuple):
    """Steps and whether they ended an episode, by time."""

    steps: list[Transitions]
    ended: list[Flags]


def episodes(rng: np.random.Generator, ends: np.ndarray[tuple[int, int], np.dtype[np.int64]]) -> Episodes:
    """Random steps, [time, env], that end as `ends` says; the state after one is not the next one's."""
    made = [
        Transitions(
            rng.random((N_ENVS, SIZE)).astype(np.float32),
            rng.integers(0, 2, N_ENVS),
            rng.integers(0, 6, N_ENVS),
            rng.normal(size=(N_ENVS, 2)),
            np.where(end == TERMINAL, 0.0, GAMMA),
            rng.random((N_ENVS, SIZE)).astype(np.float32),
        )
        for end in ends
    ]
    return Episodes(made, [end != RUNNING for end in ends])


def assert_joined(joined: Transitions, played: Episodes, begin: int, n_steps: int) -> None:
    """Every environment's transition is what one loop over its own steps from `begin` on gives."""
    for at in range(N_ENVS):
        reward, discount, now = np.zeros(2), np.float64(1.0), begin
        while True:
            reward = reward + discount * played.steps[now].rewards[at]
            discount = discount * np.float64(played.steps[now].discounts[at])
            if played.ended[now][at] or now == begin + n_steps - 1:
                break
            now += 1
        first, last = played.steps[begin], played.steps[now]
        np.testing.assert_allclose(joined.rewards[at], reward, rtol=1e-12)
        assert joined.discounts[at] == pytest.approx(discount, rel=1e-12)
        np.testing.assert_array_equal(joined.observations[at], first.observations[at])
        np.testing.assert_array_equal(joined.next_observations[at], last.next_observations[at])
        assert joined.options[at] == first.options[at]
        assert joined.actions[at] == first.actions[at]


@pytest.mark.parametrize("n_steps", [1, 2, 3, 5])
@pytest.mark.parametrize("chance", [0.0, 0.15, 0.6])
def test_returns_are_those_of_a_plain_loop(n_steps: int, chance: float) -> None:
    rng = np.random.default_rng(n_steps)
    ends = rng.choice([RUNNING, TERMINAL, TRUNCATED], (STEPS, N_ENVS), p=[1 - chance, chance / 2, chance / 2])
    played, window = episodes(rng, ends), MultiStep(n_steps)
    for now, (step, ended) in enumerate(zip(*played, strict=True)):
        joined = window.push(step, ended)
        if now < n_steps - 1:
            assert joined is None
        else:
            assert joined is not None
            assert_joined(joined, played, now - n_steps + 1, n_steps)


def test_one_step_is_the_step_itself() -> None:
    played = episodes(np.random.default_rng(0), np.full((1, N_ENVS), RUNNING))
    assert MultiStep(1).push(played.steps[0], played.ended[0]) is played.steps[0]


@pytest.mark.parametrize(("end", "discount"), [(TERMINAL, 0.0), (TRUNCATED, GAMMA**2)])
def test_an_end_in_the_middle_stops_reward_and_state(end: int, discount: float) -> None:
    ends = np.full((4, N_ENVS), RUNNING)
    ends[1] = end
    played, window = episodes(np.random.default_rng(0), ends), MultiStep(4)
    joined = [window.push(step, ended) for step, ended in zip(*played, strict=True)][-1]
    assert joined is not None
    np.testing.assert_allclose(joined.discounts, discount)
    np.testing.assert_allclose(joined.rewards, played.steps[0].rewards + GAMMA * played.steps[1].rewards)
    np.testing.assert_array_equal(joined.next_observations, played.steps[1].next_observations)
