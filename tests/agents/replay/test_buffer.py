import numpy as np

from hhrl_agents.agent import NO_ACTION
from hhrl_agents.replay.buffer import ACTIONS, DISCOUNT, NUMBERS, OPTIONS, REWARDS, ReplayBuffer, Transitions
from hhrl_envs.arrays import Ints
from hhrl_envs.observation import SIZE


def step(rng: np.random.Generator, n: int) -> Transitions:
    return Transitions(
        rng.random((n, SIZE)).astype(np.float32),
        rng.integers(-1, 2, n),
        rng.integers(0, 6, n),
        rng.random((n, 2)),
        rng.choice([0.0, 0.99], n),
        rng.random((n, SIZE)).astype(np.float32),
    )


def assert_is(buffer: ReplayBuffer, index: int, then: Transitions, env: int) -> None:
    """The row of this index is what `env` did in that step."""
    row, numbers = buffer.rows[index], buffer.rows[index, 2 * SIZE :]
    np.testing.assert_array_equal(row[:SIZE], then.observations[env])
    np.testing.assert_array_equal(row[SIZE : 2 * SIZE], then.next_observations[env])
    np.testing.assert_array_equal(buffer.next_observations(np.array([index]))[0], then.next_observations[env])
    np.testing.assert_array_equal(numbers[REWARDS:DISCOUNT], then.rewards[env].astype(np.float32))
    assert numbers[DISCOUNT] == np.float32(then.discounts[env])
    assert numbers[OPTIONS] == then.options[env]
    assert numbers[ACTIONS] == then.actions[env]


def test_what_is_stored_comes_back_and_the_oldest_goes_first() -> None:
    rng, n = np.random.default_rng(0), 4
    buffer = ReplayBuffer(22, SIZE)
    steps: list[Transitions] = []
    where: list[Ints] = []
    for when in range(8):
        steps.append(step(rng, n))
        where.append(buffer.add(steps[-1]))
        assert buffer.stored == min(n * (when + 1), 22)
    kept = [(2, 2), (2, 3), *((when, env) for when in range(3, 8) for env in range(n))]
    assert sorted(where[when][env] for when, env in kept) == list(range(22))
    for when, env in kept:
        assert_is(buffer, where[when][env], steps[when], env)


def test_a_transition_is_a_packed_row() -> None:
    buffer = ReplayBuffer(4, SIZE)
    assert buffer.rows.shape == (4, 2 * SIZE + NUMBERS)
    assert buffer.rows.dtype == np.float32
    assert {REWARDS, REWARDS + 1, DISCOUNT, OPTIONS, ACTIONS} == set(range(NUMBERS))


def test_next_observations_are_a_copy() -> None:
    rng, buffer = np.random.default_rng(2), ReplayBuffer(4, SIZE)
    buffer.add(step(rng, 4))
    taken = buffer.next_observations(np.array([0, 1]))
    before = taken.copy()
    buffer.add(step(rng, 4))
    np.testing.assert_array_equal(taken, before)


def test_the_largest_reward_is_that_of_any_level_that_is_still_stored() -> None:
    rng, buffer = np.random.default_rng(3), ReplayBuffer(8, SIZE)
    assert buffer.largest_reward() == 0.0
    for level, reward in ((0, -7.0), (1, 9.0)):
        made = step(rng, 4)
        made.rewards[2, level] = reward
        buffer.add(made)
        assert buffer.largest_reward() == abs(reward)
    buffer.add(step(rng, 4))
    buffer.add(step(rng, 4)._replace(discounts=np.full(4, 5.0)))
    assert buffer.largest_reward() < 1.0


def test_vehicles_that_wait_are_not_stored() -> None:
    """Against a list, the oldest first, cut to the capacity."""
    for share in (0.0, 0.5, 0.9):
        rng, capacity = np.random.default_rng(4), 10
        buffer = ReplayBuffer(capacity, SIZE)
        steps: list[Transitions] = []
        held: dict[int, tuple[int, int]] = {}
        for when in range(12):
            waits, made = rng.random(4) < share, step(rng, 4)
            steps.append(made._replace(actions=np.where(waits, NO_ACTION, made.actions)))
            where = buffer.add(steps[-1])
            assert ((where < 0) == waits).all()
            held.update({int(where[vehicle]): (when, int(vehicle)) for vehicle in np.flatnonzero(~waits)})
        acted = [(when, v) for when in range(12) for v in range(4) if steps[when].actions[v] != NO_ACTION]
        assert sorted(held.values()) == acted[-capacity:]
        assert buffer.stored == len(held)
        for index, (when, vehicle) in held.items():
            assert_is(buffer, index, steps[when], vehicle)


def test_a_restored_buffer_goes_on_where_the_saved_one_was() -> None:
    rng, buffer, other = np.random.default_rng(5), ReplayBuffer(10, SIZE), ReplayBuffer(10, SIZE)
    for _ in range(3):
        buffer.add(step(rng, 4))
    other.restore(buffer.state())
    later = step(rng, 4)
    np.testing.assert_array_equal(buffer.add(later), other.add(later))
    np.testing.assert_array_equal(buffer.rows, other.rows)
