import numpy as np
import pytest

from hhrl_agents.seeding import Purpose, generators
from hhrl_agents.training.exploration import GREEDY, Explorer
from hhrl_envs.arrays import Ints


def draws(epsilon: float, longest: int, steps: int = 4000, seeds: tuple[int, ...] = (1, 2)) -> Ints:
    """What is tried in `steps` steps, [steps, E, n], of the choices 3, 4, 5."""
    explorer = Explorer(generators(seeds, Purpose.EXPLORATION), 8, np.array([3, 4, 5]), longest)
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
    lengths = [length for row in trail.reshape(len(trail), -1).T for length in runs(row)]
    single = [length for length in lengths if length <= 5]
    assert set(single) == {1, 2, 3, 4, 5}
    assert len(single) > 0.8 * len(lengths)


def test_plain_epsilon_greedy_does_not_hold() -> None:
    trail = draws(0.5, 1, 4000)[:, 0, 0]
    both = np.mean((trail[1:] != GREEDY) & (trail[:-1] != GREEDY))
    assert abs(both - 0.25) < 0.05


def test_a_seed_explores_the_same_alone() -> None:
    np.testing.assert_array_equal(draws(0.3, 10, 100, (1, 2))[:, 1], draws(0.3, 10, 100, (2,))[:, 0])
