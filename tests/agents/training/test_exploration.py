import numpy as np
import pytest

from hhrl_agents.seeding import Purpose, generator
from hhrl_agents.training.exploration import GREEDY, Explorer
from hhrl_envs.arrays import Ints


def draws(epsilon: float, longest: int, steps: int = 4000, seed: int = 1) -> Ints:
    """What is tried in `steps` steps, [steps, n], of the choices 3, 4, 5."""
    explorer = Explorer(generator(seed, Purpose.EXPLORATION), 16, np.array([3, 4, 5]), longest)
    return np.stack([explorer.draw(epsilon) for _ in range(steps)])


def runs(trail: Ints) -> list[int]:
    """Lengths of the stretches without a greedy step in a trail of one environment."""
    tried = np.concatenate(([False], trail != GREEDY, [False]))
    edges = np.flatnonzero(np.diff(tried.astype(np.int64)))
    return list(edges[1::2] - edges[::2])


@pytest.mark.parametrize("longest", [1, 10, 20])
@pytest.mark.parametrize("epsilon", [0.02, 0.3, 0.9])
def test_a_share_epsilon_of_steps_tries(epsilon: float, longest: int) -> None:
    share = np.mean(draws(epsilon, longest) != GREEDY)
    assert abs(share - epsilon) < 0.15 * min(epsilon, 1 - epsilon) + 0.01


def test_epsilon_one_always_tries_and_zero_never() -> None:
    assert np.all(draws(1.0, 20, 200) != GREEDY)
    assert np.all(draws(0.0, 20, 200) == GREEDY)


def test_tries_each_choice_as_often_as_the_others() -> None:
    trail = draws(1.0, 1, 1000)
    counts = np.bincount(trail.reshape(-1))[3:]
    assert np.abs(counts - trail.size / 3).max() < 5 * np.sqrt(trail.size / 3)


def test_a_choice_is_held_for_1_to_longest_steps() -> None:
    trail = draws(0.02, 5)
    lengths = [length for row in trail.T for length in runs(row)]
    single = [length for length in lengths if length <= 5]
    assert set(single) == {1, 2, 3, 4, 5}
    assert len(single) > 0.8 * len(lengths)


def test_plain_epsilon_greedy_does_not_hold() -> None:
    trail = draws(0.5, 1, 4000)[:, 0]
    both = np.mean((trail[1:] != GREEDY) & (trail[:-1] != GREEDY))
    assert abs(both - 0.25) < 0.05


def test_explorers_of_two_seeds_in_turn_draw_what_each_draws_alone() -> None:
    explorers = [Explorer(generator(seed, Purpose.EXPLORATION), 16, np.array([3, 4, 5]), longest=10) for seed in (1, 2)]
    drawn = np.stack([[explorer.draw(0.3) for explorer in explorers] for _ in range(100)], axis=1)
    for seed, trail in zip((1, 2), drawn, strict=True):
        np.testing.assert_array_equal(trail, draws(0.3, 10, 100, seed))
    assert (drawn[0] != drawn[1]).any()
