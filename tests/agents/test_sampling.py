from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from hhrl_agents.base import Float32Array, FloatArray
from hhrl_agents.methods import LearnerConfig
from hhrl_agents.sampling import (
    SCALE_RATE,
    HierarchicalPrioritizedSampler,
    UniformSampler,
)
from hhrl_agents.seeding import Purpose, generators

CONFIG = LearnerConfig(batch_size=16, priority_floor=0.05, priority_exponent=0.7, importance_exponent=0.5)
ALPHA, BETA, FLOOR = CONFIG.priority_exponent, CONFIG.importance_exponent, CONFIG.priority_floor
SEEDS = (1, 2, 3)
STORED = 50


def sampler(config: LearnerConfig = CONFIG, seeds: tuple[int, ...] = SEEDS) -> HierarchicalPrioritizedSampler:
    made = HierarchicalPrioritizedSampler(generators(seeds, Purpose.REPLAY), capacity=60, config=config)
    made.added(np.arange(STORED))
    return made


def errors_of(rng: np.random.Generator, seeds: int = len(SEEDS), size: int = STORED) -> Float32Array:
    errors = np.abs(rng.normal(size=(2, seeds, size))).astype(np.float32)
    errors[1] *= 5.0
    return errors


def leaves(made: HierarchicalPrioritizedSampler) -> FloatArray:
    """The priorities to the power of alpha, [levels, E, stored]."""
    trees = made._trees.reshape(2, -1, made._trees.shape[1])
    return trees[..., trees.shape[-1] // 2 :][..., :STORED]


def all_indices() -> np.ndarray[tuple[int, int], np.dtype[np.int64]]:
    return np.tile(np.arange(STORED), (len(SEEDS), 1))


def test_priorities_are_those_of_the_hierarchy() -> None:
    made, errors = sampler(), errors_of(np.random.default_rng(0))
    made.update(all_indices(), errors)
    scaled = errors / errors.mean(-1, keepdims=True)
    option = scaled[0] + FLOOR
    action = np.maximum(scaled[1] - scaled[0], 0.0) + FLOOR
    np.testing.assert_allclose(leaves(made), np.stack((option, action)) ** ALPHA, rtol=1e-5)


def test_the_magnitude_of_errors_runs_along() -> None:
    made, rng = sampler(), np.random.default_rng(0)
    first, second = errors_of(rng), 3.0 * errors_of(rng)
    made.update(all_indices(), first)
    made.update(all_indices(), second)
    magnitude = first.mean(-1) + SCALE_RATE * (second.mean(-1) - first.mean(-1))
    option = second[0] / magnitude[0][:, None] + FLOOR
    np.testing.assert_allclose(leaves(made)[0], option**ALPHA, rtol=1e-5)


def test_shift_is_the_printed_priority() -> None:
    made, errors = sampler(replace(CONFIG, priority="shift")), errors_of(np.random.default_rng(0))
    made.update(all_indices(), errors)
    gap = errors[1].astype(np.float64) - errors[0]
    expected = np.stack((errors[0], gap - gap.min(-1, keepdims=True))) + FLOOR
    np.testing.assert_allclose(leaves(made), expected**ALPHA, rtol=1e-5)


def test_importance_weights_undo_the_priorities() -> None:
    made, errors = sampler(), errors_of(np.random.default_rng(0))
    made.update(all_indices(), errors)
    chances = leaves(made) / leaves(made).sum(-1, keepdims=True)
    draw = made.draw(STORED)
    size = CONFIG.batch_size
    assert draw.indices.shape == (len(SEEDS), 2 * size)
    assert draw.weights.shape == (2, len(SEEDS), 2 * size)
    for level in range(2):
        own, other = slice(level * size, (level + 1) * size), slice((1 - level) * size, (2 - level) * size)
        taken = np.take_along_axis(chances[level], draw.indices[:, own], axis=-1)
        weights = (STORED * taken) ** -BETA
        np.testing.assert_allclose(draw.weights[level][:, own], weights / weights.max(-1, keepdims=True), rtol=1e-5)
        assert not draw.weights[level][:, other].any()


def test_each_level_draws_by_its_own_priorities() -> None:
    made, errors = sampler(), errors_of(np.random.default_rng(0))
    made.update(all_indices(), errors)
    chances = leaves(made) / leaves(made).sum(-1, keepdims=True)
    drawn = np.stack([made.draw(STORED).indices for _ in range(600)]).reshape(600, len(SEEDS), 2, -1)
    for level in range(2):
        for e in range(len(SEEDS)):
            counts = np.bincount(drawn[:, e, level].reshape(-1), minlength=STORED)
            assert stats.chisquare(counts, chances[level, e] * counts.sum()).pvalue > 1e-3


def test_new_transitions_get_the_highest_priority() -> None:
    made, errors = sampler(), errors_of(np.random.default_rng(0))
    made.update(all_indices(), errors)
    highest = leaves(made).max(-1)
    made.added(np.array([3, 4]))
    np.testing.assert_array_equal(leaves(made)[..., 3:5], np.broadcast_to(highest[..., None], (2, len(SEEDS), 2)))


def test_a_seed_draws_the_same_alone() -> None:
    together, errors = sampler(), errors_of(np.random.default_rng(0))
    together.update(all_indices(), errors)
    alone = sampler(seeds=SEEDS[1:2])
    alone.update(all_indices()[1:2], errors[:, 1:2])
    np.testing.assert_array_equal(together.draw(STORED).indices[1], alone.draw(STORED).indices[0])


def test_uniform_draws_are_uniform_over_what_is_stored() -> None:
    made = UniformSampler(generators(SEEDS, Purpose.REPLAY), 64)
    drawn = np.stack([made.draw(STORED).indices for _ in range(300)])
    assert drawn.shape == (300, len(SEEDS), 64)
    for e in range(len(SEEDS)):
        counts = np.bincount(drawn[:, e].reshape(-1), minlength=STORED)
        assert len(counts) == STORED
        assert stats.chisquare(counts).pvalue > 1e-3


@pytest.mark.parametrize("size", [1, 16])
def test_uniform_weights_are_one(size: int) -> None:
    draw = UniformSampler(generators(SEEDS, Purpose.REPLAY), size).draw(STORED)
    assert (np.broadcast_to(draw.weights, (2, len(SEEDS), size)) == 1.0).all()
