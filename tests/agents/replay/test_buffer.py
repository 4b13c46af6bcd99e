import numpy as np
import torch

from hhrl_agents.agent import NO_ACTION
from hhrl_agents.replay.buffer import MiniBatch, ReplayBuffer, Transitions
from hhrl_envs.observation import SIZE

CPU = torch.device("cpu")


def step(rng: np.random.Generator, seeds: int, n: int) -> Transitions:
    return Transitions(
        rng.random((seeds, n, SIZE)).astype(np.float32),
        rng.integers(-1, 2, (seeds, n)),
        rng.integers(0, 6, (seeds, n)),
        rng.random((seeds, n, 2)),
        rng.choice([0.0, 0.99], (seeds, n)),
        rng.random((seeds, n, SIZE)).astype(np.float32),
    )


def assert_is(batch: MiniBatch, k: int, steps: list[Transitions], seed: int, when: int, env: int) -> None:
    """Column k of the batch is what `env` of `seed` did in step `when`."""
    then = steps[when]
    np.testing.assert_array_equal(batch.observations[seed, :, k], then.observations[seed, env])
    np.testing.assert_array_equal(batch.next_observations[seed, :, k], then.next_observations[seed, env])
    rewards = (batch.option_rewards[seed, 0, k], batch.action_rewards[seed, 0, k])
    np.testing.assert_allclose(rewards, then.rewards[seed, env], rtol=1e-6)
    np.testing.assert_allclose(batch.discounts[seed, 0, k], then.discounts[seed, env], rtol=1e-6)
    assert batch.options[seed, 0, k] == then.options[seed, env]
    assert batch.actions[seed, 0, k] == then.actions[seed, env]


def test_what_is_stored_comes_back_and_the_oldest_goes_first() -> None:
    rng, seeds, n = np.random.default_rng(0), 3, 4
    buffer = ReplayBuffer(seeds, 22, SIZE, CPU)
    steps, where = [], []
    for when in range(8):
        steps.append(step(rng, seeds, n))
        where.append(buffer.add(steps[-1]))
        assert (buffer.stored == min(n * (when + 1), 22)).all()
    kept = [(2, 2), (2, 3), *((when, env) for when in range(3, 8) for env in range(n))]
    indices = np.stack([where[when][:, env] for when, env in kept], axis=1)
    assert (np.sort(indices, axis=1) == np.arange(22)).all()
    batch = buffer.gather(indices)
    for k, (when, env) in enumerate(kept):
        for seed in range(seeds):
            assert_is(batch, k, steps, seed, when, env)


def test_each_seed_gathers_its_own_indices() -> None:
    rng = np.random.default_rng(1)
    buffer, only = ReplayBuffer(2, 4, SIZE, CPU), step(rng, 2, 4)
    buffer.add(only)
    batch = buffer.gather(np.array([[0, 3], [2, 2]]))
    for seed, k, env in ((0, 0, 0), (0, 1, 3), (1, 0, 2), (1, 1, 2)):
        assert_is(batch, k, [only], seed, 0, env)


def test_a_batch_is_a_copy() -> None:
    rng = np.random.default_rng(2)
    buffer = ReplayBuffer(1, 4, SIZE, CPU)
    buffer.add(step(rng, 1, 4))
    batch = buffer.gather(np.array([[0, 1]]))
    before = [part.clone() for part in batch]
    buffer.add(step(rng, 1, 4))
    assert all(torch.equal(part, kept) for part, kept in zip(batch, before, strict=True))


def test_columns_have_their_features_first() -> None:
    buffer = ReplayBuffer(2, 4, SIZE, CPU)
    buffer.add(step(np.random.default_rng(3), 2, 4))
    batch = buffer.gather(np.array([[0, 3, 1], [2, 2, 0]]))
    assert [part.shape[1] for part in batch] == [SIZE, 1, 1, 1, 1, 1, SIZE]
    assert all((part.shape[0], part.shape[2]) == (2, 3) for part in batch)
    assert (batch.options.dtype, batch.actions.dtype) == (torch.int64, torch.int64)


def test_vehicles_that_wait_are_not_stored_and_seeds_fill_at_their_own_pace() -> None:
    """Against a list for each seed, the oldest first, cut to the capacity."""
    rng, seeds, capacity = np.random.default_rng(4), 3, 10
    buffer = ReplayBuffer(seeds, capacity, SIZE, CPU)
    steps, held = [], [dict[int, tuple[int, int]]() for _ in range(seeds)]
    for when in range(12):
        waits = rng.random((seeds, 4)) < np.array([[0.0], [0.5], [0.9]])
        made = step(rng, seeds, 4)
        steps.append(made._replace(actions=np.where(waits, NO_ACTION, made.actions)))
        where = buffer.add(steps[-1])
        assert ((where < 0) == waits).all()
        for seed, vehicle in zip(*np.nonzero(~waits), strict=True):
            held[seed].pop(int(where[seed, vehicle]), None)
            held[seed][int(where[seed, vehicle])] = (when, int(vehicle))
    for seed in range(seeds):
        acted = [(when, v) for when in range(12) for v in range(4) if steps[when].actions[seed, v] != NO_ACTION]
        assert sorted(held[seed].values()) == acted[-capacity:]
        assert buffer.stored[seed] == len(held[seed])
        batch = buffer.gather(np.tile(list(held[seed]), (seeds, 1)))
        for k, (when, vehicle) in enumerate(held[seed].values()):
            assert_is(batch, k, steps, seed, when, vehicle)
