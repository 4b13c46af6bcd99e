from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from hhrl_agents import METHODS
from hhrl_agents.methods.configs import DoubleDQNConfig
from hhrl_agents.replay.buffer import Draw, UniformSampler
from hhrl_agents.replay.hierarchical import SCALE_RATE, HierarchicalSampler, PrioritisedSampler, make_sampler
from hhrl_agents.seeding import Purpose, generators
from hhrl_envs.arrays import Floats, Ints

CONFIG = DoubleDQNConfig(batch_size=16, priority_floor=0.05, priority_exponent=0.7, importance_exponent=0.5)
ALPHA, BETA, FLOOR = CONFIG.priority_exponent, CONFIG.importance_exponent, CONFIG.priority_floor
SEEDS = (1, 2, 3)
STORED, SIZE = 50, CONFIG.batch_size
ALL: Ints = np.tile(np.arange(STORED), (len(SEEDS), 1))
HELD: Ints = np.full(len(SEEDS), STORED)
BOTH_KINDS = pytest.mark.parametrize(("levels", "trees"), [(1, 1), (2, 1), (2, 2)])


def sampler(
    levels: int = 2, trees: int = 2, config: DoubleDQNConfig = CONFIG, seeds: tuple[int, ...] = SEEDS
) -> PrioritisedSampler:
    kind = HierarchicalSampler if trees > 1 else PrioritisedSampler
    made = kind(generators(seeds, Purpose.REPLAY), levels, 60, config)
    made.added(ALL[: len(seeds)])
    return made


def errors_of(rng: np.random.Generator, levels: int = 2) -> Floats:
    errors = np.abs(rng.normal(size=(levels, len(SEEDS), STORED)))
    errors[-1] *= 5.0
    return errors


def leaves(made: PrioritisedSampler, seeds: int = len(SEEDS)) -> Floats:
    """The priorities to the power of alpha, [trees, E, stored]."""
    indices = np.tile(np.arange(STORED), (len(made._trees.nodes), 1))
    return made._trees.priorities(indices).reshape(-1, seeds, STORED)


def chances(made: PrioritisedSampler) -> Floats:
    held = leaves(made)
    shares: Floats = held / held.sum(-1, keepdims=True)
    return shares


def by_tree(draw: Draw, trees: int) -> Ints:
    """The drawn indices, [E, trees, K]."""
    return draw.indices.reshape(len(SEEDS), trees, -1)


def test_priorities_are_those_of_the_hierarchy() -> None:
    made, errors = sampler(), errors_of(np.random.default_rng(0))
    made.update(ALL, errors)
    scaled = errors / errors.mean(-1, keepdims=True)
    option = scaled[0] + FLOOR
    action = np.maximum(scaled[1] - scaled[0], 0.0) + FLOOR
    np.testing.assert_allclose(leaves(made), np.stack((option, action)) ** ALPHA, rtol=1e-10)


def test_shift_is_the_printed_priority() -> None:
    made, errors = sampler(config=replace(CONFIG, priority="shift")), errors_of(np.random.default_rng(0))
    made.update(ALL, errors)
    gap = errors[1] - errors[0]
    expected = np.stack((errors[0], gap - gap.min(-1, keepdims=True))) + FLOOR
    np.testing.assert_allclose(leaves(made), expected**ALPHA, rtol=1e-10)


@pytest.mark.parametrize("levels", [1, 2])
@pytest.mark.parametrize("priority", ["clip", "shift"])
def test_the_plain_priority_is_the_mean_error_of_all_levels(levels: int, priority: str) -> None:
    config = CONFIG if priority == "clip" else replace(CONFIG, priority="shift")
    made, errors = sampler(levels, 1, config), errors_of(np.random.default_rng(0), levels)
    made.update(ALL, errors)
    scaled = (errors / errors.mean(-1, keepdims=True)).sum(0) / levels
    np.testing.assert_allclose(leaves(made)[0], (scaled + FLOOR) ** ALPHA, rtol=1e-10)


@BOTH_KINDS
def test_the_magnitude_of_errors_runs_along(levels: int, trees: int) -> None:
    made, rng = sampler(levels, trees), np.random.default_rng(0)
    first, second = errors_of(rng, levels), 3.0 * errors_of(rng, levels)
    made.update(ALL, first)
    made.update(ALL, second)
    magnitude = first.mean(-1) + SCALE_RATE * (second.mean(-1) - first.mean(-1))
    scaled = second / magnitude[..., None]
    expected = scaled[0] if trees > 1 else scaled.mean(0)
    np.testing.assert_allclose(leaves(made)[0], (expected + FLOOR) ** ALPHA, rtol=1e-10)


@BOTH_KINDS
def test_importance_weights_undo_the_priorities(levels: int, trees: int) -> None:
    made = sampler(levels, trees)
    made.update(ALL, errors_of(np.random.default_rng(0), levels))
    draw, held = made.draw(HELD), chances(made)
    assert draw.indices.shape == (len(SEEDS), trees * SIZE)
    assert len(draw.parts) == len(draw.weights) == levels
    for level in range(levels):
        tree = level % trees
        assert draw.parts[level] == slice(tree * SIZE, (tree + 1) * SIZE)
        taken = np.take_along_axis(held[tree], draw.indices[:, draw.parts[level]], axis=-1)
        weights = (STORED * taken) ** -BETA
        assert draw.weights[level].shape == (len(SEEDS), 1, SIZE)
        np.testing.assert_allclose(draw.weights[level][:, 0], weights / weights.max(-1, keepdims=True), rtol=1e-5)


@BOTH_KINDS
def test_each_tree_draws_by_its_own_priorities(levels: int, trees: int) -> None:
    made = sampler(levels, trees)
    made.update(ALL, errors_of(np.random.default_rng(0), levels))
    drawn, held = np.stack([by_tree(made.draw(HELD), trees) for _ in range(600)]), chances(made)
    for tree in range(trees):
        for e in range(len(SEEDS)):
            counts = np.bincount(drawn[:, e, tree].reshape(-1), minlength=STORED)
            assert stats.chisquare(counts, held[tree, e] * counts.sum()).pvalue > 1e-3


def test_a_draw_takes_one_of_every_stratum() -> None:
    made = sampler()
    made.update(ALL, errors_of(np.random.default_rng(0)))
    ends = chances(made).cumsum(-1)
    drawn = by_tree(made.draw(HELD), 2)
    for tree in range(2):
        for e in range(len(SEEDS)):
            last = ends[tree, e][drawn[e, tree]]
            first = last - chances(made)[tree, e][drawn[e, tree]]
            strata = np.arange(SIZE) / SIZE
            assert (first < strata + 1 / SIZE).all()
            assert (last > strata).all()


@BOTH_KINDS
def test_new_transitions_get_the_highest_priority(levels: int, trees: int) -> None:
    made = sampler(levels, trees)
    made.update(ALL, errors_of(np.random.default_rng(0), levels))
    highest = leaves(made).max(-1, keepdims=True)
    made.update(ALL, np.full((levels, len(SEEDS), STORED), 1e-3))
    made.added(np.array([[3, 4, -1]] * len(SEEDS)))
    np.testing.assert_array_equal(leaves(made)[..., 3:5], np.broadcast_to(highest, (trees, len(SEEDS), 2)))


@BOTH_KINDS
def test_a_seed_draws_the_same_alone(levels: int, trees: int) -> None:
    together, errors = sampler(levels, trees), errors_of(np.random.default_rng(0), levels)
    together.update(ALL, errors)
    alone = sampler(levels, trees, seeds=SEEDS[1:2])
    alone.update(ALL[1:2], errors[:, 1:2])
    for _ in range(3):
        ours, theirs = together.draw(HELD), alone.draw(HELD[1:2])
        np.testing.assert_array_equal(ours.indices[1], theirs.indices[0])
        for weights, others in zip(ours.weights, theirs.weights, strict=True):
            np.testing.assert_array_equal(weights[1], others[0])


def test_uniform_draws_are_uniform_over_what_is_stored() -> None:
    made = UniformSampler(generators(SEEDS, Purpose.REPLAY), 1, 64)
    drawn = np.stack([made.draw(HELD).indices for _ in range(300)])
    assert drawn.shape == (300, len(SEEDS), 64)
    for e in range(len(SEEDS)):
        counts = np.bincount(drawn[:, e].reshape(-1), minlength=STORED)
        assert len(counts) == STORED
        assert stats.chisquare(counts).pvalue > 1e-3


@pytest.mark.parametrize("levels", [1, 2])
def test_uniform_weights_are_one_and_all_levels_share_the_mini_batch(levels: int) -> None:
    draw = UniformSampler(generators(SEEDS, Purpose.REPLAY), levels, SIZE).draw(HELD)
    assert draw.parts == [slice(0, SIZE)] * levels
    assert len(draw.weights) == levels
    assert all(weights.shape == (len(SEEDS), 1, SIZE) and (weights == 1.0).all() for weights in draw.weights)


@pytest.mark.parametrize(("replay", "mini_batches"), [("uniform", 1), ("prioritised", 1), ("hierarchical", 2)])
def test_a_method_s_replay_says_how_many_mini_batches_are_drawn(replay: str, mini_batches: int) -> None:
    method = replace(METHODS["hybrid-hrl"], config=CONFIG)
    method = type(method).from_data("some", {**method.data(), "replay": replay})
    made = make_sampler(method, generators(SEEDS, Purpose.REPLAY), 2, 60)
    made.added(ALL)
    assert made.draw(HELD).indices.shape == (len(SEEDS), mini_batches * SIZE)
    assert isinstance(made, UniformSampler) == (replay == "uniform")
