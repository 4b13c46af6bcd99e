from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy import stats

from hhrl_agents import METHODS
from hhrl_agents.methods.configs import DoubleDQNConfig
from hhrl_agents.replay.buffer import Draw, UniformSampler
from hhrl_agents.replay.hierarchical import SCALE_RATE, PrioritisedSampler, make_sampler
from hhrl_agents.seeding import Purpose, generator
from hhrl_envs.arrays import Floats, Floats32, Ints

CONFIG = DoubleDQNConfig(batch_size=16, priority_floor=0.05, priority_exponent=0.7, importance_exponent=0.5)
ALPHA, BETA, FLOOR = CONFIG.priority_exponent, CONFIG.importance_exponent, CONFIG.priority_floor
STORED, SIZE = 50, CONFIG.batch_size
ALL: Ints = np.arange(STORED)
BOTH_KINDS = pytest.mark.parametrize(("levels", "trees"), [(1, 1), (2, 1), (2, 2)])


def stream(seed: int = 1) -> np.random.Generator:
    return generator(seed, Purpose.REPLAY)


def sampler(levels: int = 2, trees: int = 2, config: DoubleDQNConfig = CONFIG) -> PrioritisedSampler:
    made = PrioritisedSampler(stream(), levels, 60, config, hierarchical=trees > 1)
    made.added(ALL)
    return made


def errors_of(rng: np.random.Generator, levels: int = 2) -> Floats32:
    """Errors of both signs, [levels, stored], the last level's larger."""
    errors = rng.normal(size=(levels, STORED))
    errors[-1] *= 5.0
    return errors.astype(np.float32)


def learn(made: PrioritisedSampler, errors: Floats32) -> None:
    """Let every level err by its row of errors [levels, stored] in the transitions, all of which it has drawn."""
    trees = len(made._trees.nodes)
    made.update(np.tile(ALL, trees), np.tile(errors, (1, trees)))


def magnitudes(errors: Floats32) -> Floats:
    return np.abs(errors).astype(np.float64)


def leaves(made: PrioritisedSampler) -> Floats:
    """The priorities to the power of alpha, [trees, stored]."""
    first = made._trees.starts[-1]
    held: Floats = made._trees.nodes[:, first : first + STORED].copy()
    return held


def chances(made: PrioritisedSampler) -> Floats:
    held = leaves(made)
    shares: Floats = held / held.sum(-1, keepdims=True)
    return shares


def by_tree(draw: Draw, trees: int) -> Ints:
    """The drawn indices, [trees, K]."""
    return draw.indices.reshape(trees, -1)


def test_priorities_are_those_of_the_hierarchy() -> None:
    made, errors = sampler(), errors_of(np.random.default_rng(0))
    learn(made, errors)
    scaled = magnitudes(errors) / magnitudes(errors).mean(-1, keepdims=True)
    option = scaled[0] + FLOOR
    action = np.maximum(scaled[1] - scaled[0], 0.0) + FLOOR
    np.testing.assert_allclose(leaves(made), np.stack((option, action)) ** ALPHA, rtol=1e-10)


def test_shift_is_the_printed_priority() -> None:
    made, errors = sampler(config=replace(CONFIG, priority="shift")), errors_of(np.random.default_rng(0))
    learn(made, errors)
    option, action = magnitudes(errors)
    gap = action - option
    expected = np.stack((option, gap - gap.min())) + FLOOR
    np.testing.assert_allclose(leaves(made), expected**ALPHA, rtol=1e-10)


def test_the_action_level_s_priority_is_less_what_the_option_level_found_when_it_last_learned() -> None:
    """Each level learns from transitions of its own; p^o is 0 where the option level has not yet learned."""
    made, rng = sampler(), np.random.default_rng(0)
    own, others = np.arange(0, 10), np.arange(5, 15)
    errors = rng.normal(size=(2, 20)).astype(np.float32)
    made.update(np.concatenate((own, others)), errors)
    of_option = np.abs(errors[0, :10]).astype(float) / np.abs(errors[0, :10]).mean(dtype=float)
    action = np.abs(errors[1, 10:]).astype(float) / np.abs(errors[1, 10:]).mean(dtype=float)
    p_o = np.concatenate((of_option[5:], np.zeros(5)))
    np.testing.assert_allclose(leaves(made)[0, own], (of_option + FLOOR) ** ALPHA, rtol=1e-6)
    np.testing.assert_allclose(leaves(made)[1, others], (np.maximum(action - p_o, 0.0) + FLOOR) ** ALPHA, rtol=1e-6)
    made.added(np.array([5]))
    made.update(np.array([0, 5]), np.full((2, 2), 2.0, np.float32))
    scale = np.abs(errors[1, 10:]).mean(dtype=float)
    scale += SCALE_RATE * (2.0 - scale)
    np.testing.assert_allclose(leaves(made)[1, 5], (2.0 / scale + FLOOR) ** ALPHA, rtol=1e-6)


@pytest.mark.parametrize("levels", [1, 2])
@pytest.mark.parametrize("priority", ["clip", "shift"])
def test_the_plain_priority_is_the_mean_error_of_all_levels(levels: int, priority: Any) -> None:
    made, errors = sampler(levels, 1, replace(CONFIG, priority=priority)), errors_of(np.random.default_rng(0), levels)
    learn(made, errors)
    scaled = (magnitudes(errors) / magnitudes(errors).mean(-1, keepdims=True)).sum(0) / levels
    np.testing.assert_allclose(leaves(made)[0], (scaled + FLOOR) ** ALPHA, rtol=1e-10)


@BOTH_KINDS
def test_the_magnitude_of_errors_runs_along(levels: int, trees: int) -> None:
    made, rng = sampler(levels, trees), np.random.default_rng(0)
    first, second = errors_of(rng, levels), np.float32(3.0) * errors_of(rng, levels)
    learn(made, first)
    learn(made, second)
    before, after = magnitudes(first).mean(-1), magnitudes(second).mean(-1)
    scaled = magnitudes(second) / (before + SCALE_RATE * (after - before))[:, None]
    expected = scaled[0] if trees > 1 else scaled.mean(0)
    np.testing.assert_allclose(leaves(made)[0], (expected + FLOOR) ** ALPHA, rtol=1e-10)


@BOTH_KINDS
def test_importance_weights_undo_the_priorities(levels: int, trees: int) -> None:
    made = sampler(levels, trees)
    learn(made, errors_of(np.random.default_rng(0), levels))
    draw, held = made.draw(STORED), chances(made)
    assert draw.indices.shape == (trees * SIZE,)
    assert draw.weights.shape == (levels, SIZE)
    assert draw.weights.dtype == np.float32
    for level in range(levels):
        tree = level % trees
        assert draw.firsts[level] == tree * SIZE
        taken = held[tree, draw.indices[draw.firsts[level] :][:SIZE]]
        weights = (STORED * taken) ** -BETA
        np.testing.assert_allclose(draw.weights[level], weights / weights.max(), rtol=1e-5)


@BOTH_KINDS
def test_each_tree_draws_by_its_own_priorities(levels: int, trees: int) -> None:
    made = sampler(levels, trees)
    learn(made, errors_of(np.random.default_rng(0), levels))
    drawn, held = np.stack([by_tree(made.draw(STORED), trees) for _ in range(600)]), chances(made)
    for tree in range(trees):
        counts = np.bincount(drawn[:, tree].reshape(-1), minlength=STORED)
        assert stats.chisquare(counts, held[tree] * counts.sum()).pvalue > 1e-3


def test_a_draw_takes_one_of_every_stratum() -> None:
    made = sampler()
    learn(made, errors_of(np.random.default_rng(0)))
    ends, drawn = chances(made).cumsum(-1), by_tree(made.draw(STORED), 2)
    for tree in range(2):
        last = ends[tree][drawn[tree]]
        first = last - chances(made)[tree][drawn[tree]]
        strata = np.arange(SIZE) / SIZE
        assert (first < strata + 1 / SIZE).all()
        assert (last > strata).all()


@BOTH_KINDS
def test_new_transitions_get_the_highest_priority(levels: int, trees: int) -> None:
    made = sampler(levels, trees)
    learn(made, errors_of(np.random.default_rng(0), levels))
    highest = leaves(made).max(-1, keepdims=True)
    learn(made, np.full((levels, STORED), 1e-3, np.float32))
    made.added(np.array([3, 4, -1]))
    np.testing.assert_array_equal(leaves(made)[:, 3:5], np.broadcast_to(highest, (trees, 2)))


@BOTH_KINDS
def test_a_sampler_draws_the_same_beside_another_one(levels: int, trees: int) -> None:
    alone, beside, other = (sampler(levels, trees) for _ in range(3))
    errors = errors_of(np.random.default_rng(0), levels)
    learn(alone, errors)
    expected = [alone.draw(STORED) for _ in range(3)]
    learn(other, errors[:, ::-1].copy())
    learn(beside, errors)
    for draw in expected:
        other.draw(STORED)
        for part, same in zip(beside.draw(STORED), draw, strict=True):
            np.testing.assert_array_equal(part, same)


@BOTH_KINDS
def test_a_restored_sampler_goes_on_where_the_saved_one_was(levels: int, trees: int) -> None:
    made, rng = sampler(levels, trees), np.random.default_rng(0)
    learn(made, errors_of(rng, levels))
    fresh = PrioritisedSampler(stream(9), levels, 60, CONFIG, hierarchical=trees > 1)
    fresh.restore(made.state())
    later = errors_of(rng, levels)
    for one in (made, fresh):
        learn(one, later)
        one.added(np.array([7]))
    np.testing.assert_array_equal(leaves(made), leaves(fresh))
    for part, same in zip(made.draw(STORED), fresh.draw(STORED), strict=True):
        np.testing.assert_array_equal(part, same)


def test_uniform_draws_are_uniform_over_what_is_stored() -> None:
    made = UniformSampler(stream(), 1, 64)
    drawn = np.stack([made.draw(STORED).indices for _ in range(300)])
    assert drawn.shape == (300, 64)
    counts = np.bincount(drawn.reshape(-1), minlength=STORED)
    assert len(counts) == STORED
    assert stats.chisquare(counts).pvalue > 1e-3


@pytest.mark.parametrize("levels", [1, 2])
def test_uniform_weights_are_one_and_all_levels_share_the_mini_batch(levels: int) -> None:
    draw = UniformSampler(stream(), levels, SIZE).draw(STORED)
    assert draw.firsts.tolist() == [0] * levels
    assert draw.weights.shape == (levels, SIZE)
    assert (draw.weights == 1.0).all()


@pytest.mark.parametrize(("replay", "mini_batches"), [("uniform", 1), ("prioritised", 1), ("hierarchical", 2)])
def test_a_method_s_replay_says_how_many_mini_batches_are_drawn(replay: str, mini_batches: int) -> None:
    method = replace(METHODS["hybrid-hrl"], config=CONFIG)
    method = type(method).from_data("some", {**method.data(), "replay": replay})
    made = make_sampler(method, stream(), 2, 60)
    made.added(ALL)
    assert made.draw(STORED).indices.shape == (mini_batches * SIZE,)
    assert isinstance(made, UniformSampler) == (replay == "uniform")
