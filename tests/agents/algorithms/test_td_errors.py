"""A compiled gradient step beside plain torch, float64 with autograd: errors, losses, gradients and Adam's steps."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor

from hhrl_agents import METHODS
from hhrl_agents.agent import ACTION, OPTION
from hhrl_agents.algorithms.double_dqn import DoubleDQNLearner
from hhrl_agents.algorithms.td_errors import Batch, Found, Settings, learn
from hhrl_agents.training.exploration import GREEDY, level_choices
from hhrl_agents.training.learner import Start
from hhrl_envs import Scenario, get_scenario
from hhrl_envs.arrays import Floats32, Ints
from hhrl_envs.observation import SIZE
from support import plain_learning, plain_networks

MAIN = get_scenario("stop-line-v0")
ALONE = replace(MAIN, id="alone", traffic=replace(MAIN.traffic, count_shares=(1.0,)))
K = 11
KINDS: list[tuple[str, dict[str, Any]]] = [
    ("ddqn", {}),
    ("ddqn", {"layer_norm": True}),
    ("hrl-0", {}),
    ("hybrid-hrl", {}),
    ("hybrid-hrl", {"attended": "linear"}),
    ("hybrid-hrl", {"layer_norm": True}),
    ("hybrid-hrl", {"sees_line": False, "advantage_learning": 0.9}),
    ("hybrid-hrl", {"memory": (0.1, 0.03), "advantage_learning": 0.5}),
    ("ddqn", {"memory": (0.5,), "advantage_learning": 0.3, "layer_norm": True}),
    ("rule-option", {}),
    ("option-only", {"advantage_learning": 0.5}),
]
VARIANTS = pytest.mark.parametrize(("name", "config"), KINDS)


class Subject:
    """A learner whose target networks differ from the online ones; it takes steps that a test makes up."""

    def __init__(self, name: str, scenario: Scenario = MAIN, fixed: tuple[str, ...] = (), **config: Any) -> None:
        method = METHODS[name]
        small = {"hidden": (16, 12), "n_envs": 2, "batch_size": K, "warmup": 10, "replay_capacity": 100, **config}
        self.method, self.scenario = replace(method, config=replace(method.config, **small)), scenario
        worlds = np.arange(2, dtype=np.uint64)
        self.learner = DoubleDQNLearner(self.method, scenario, 4, worlds, start=Start(fixed=fixed))
        self.levels = self.learner.levels
        parameters, rng = self.learner.parameters, np.random.default_rng(1)
        for flat in (parameters.online, parameters.target):
            flat[:] = flat + rng.normal(0.0, 0.2, flat.size).astype(np.float32)

    def named(self, flat: Floats32) -> dict[str, Floats32]:
        return {name: value.copy() for name, value in self.learner.parameters._views(flat).items()}

    @property
    def online(self) -> plain_networks.Leaves:
        return plain_networks.leaves(self.named(self.learner.parameters.online))

    @property
    def target(self) -> plain_networks.Leaves:
        return plain_networks.leaves(self.named(self.learner.parameters.target))

    @property
    def gradients(self) -> dict[str, Floats32]:
        """The gradients of the last step, before they were clipped."""
        return self.named(self.learner._memory.gradient)

    def batch(self, seed: int = 0) -> Batch:
        """A batch of K transitions, drawn from among 2 K, that every level learns from with a weight of 1."""
        rng, count, features = np.random.default_rng(seed), 2 * K, self.method.config.features
        numbers = (
            rng.normal(size=(count, 2)),
            rng.choice([0.0, 0.97], (count, 1)),
            rng.integers(0, 2, (count, 1)),
            rng.integers(0, self.scenario.num_actions, (count, 1)),
        )
        rows = np.concatenate((rng.normal(size=(count, 2 * features)), *numbers), axis=1).astype(np.float32)
        levels = len(self.levels)
        firsts, weights = np.zeros(levels, np.int64), np.ones((levels, K), np.float32)
        return Batch(rows, rng.integers(0, count, K), rng.integers(0, 2, K), firsts, weights)

    def weighted(self, seed: int = 0, size: int = 5) -> Batch:
        """A batch in which each level learns, with weights, from `size` transitions of its own."""
        firsts = np.arange(len(self.levels)) * (K - size)
        weights = np.random.default_rng(seed).random((len(self.levels), size)).astype(np.float32)
        return self.batch(seed)._replace(firsts=firsts, weights=weights)

    def step(self, batch: Batch, learning_rate: float = 1e-3, max_norm: float = 1e9) -> Found:
        learner, levels = self.learner, len(self.levels)
        found = Found(np.zeros((levels, K), np.float32), np.zeros(levels), np.zeros(levels))
        settings = Settings(self.method.config.advantage_learning, learning_rate, max_norm)
        learn(learner._memory, learner._levels, batch, learner._room, settings, found)
        return found

    def expected_errors(self, batch: Batch, online: plain_networks.Leaves) -> dict[str, Tensor]:
        step = plain_learning.transitions(batch.rows[batch.indices])
        return plain_learning.td_errors(self.method, self.scenario, online, self.target, step, batch.given)

    def expected_losses(self, batch: Batch, online: plain_networks.Leaves) -> dict[str, Tensor]:
        """The weighted mean squared error of every level that learns."""
        errors = self.expected_errors(batch, online)
        size = batch.weights.shape[1]
        return {
            level: (torch.from_numpy(weights).double() * errors[level][first : first + size].square()).mean()
            for level, first, weights in zip(self.levels, batch.firsts, batch.weights, strict=True)
        }


def assert_close(ours: Mapping[str, Floats32], theirs: plain_networks.Leaves, rtol: float, atol: float) -> None:
    for key, value in theirs.items():
        np.testing.assert_allclose(ours[key][0], value.detach(), rtol=rtol, atol=atol, err_msg=key)


@VARIANTS
def test_errors_are_those_of_double_dqn_at_every_level(name: str, config: dict[str, Any]) -> None:
    subject = Subject(name, **config)
    batch = subject.batch()
    expected = subject.expected_errors(batch, subject.online)
    assert list(expected) == list(subject.levels)
    for level, errors in zip(subject.levels, subject.step(batch).errors, strict=True):
        np.testing.assert_allclose(errors, expected[level].detach(), rtol=1e-4, atol=2e-5)


@VARIANTS
@pytest.mark.parametrize("weighted", [False, True])
def test_losses_and_gradients_are_those_of_weighted_squared_errors(
    name: str, config: dict[str, Any], weighted: bool
) -> None:
    subject = Subject(name, **config)
    batch, online = subject.weighted() if weighted else subject.batch(), subject.online
    expected = subject.expected_losses(batch, online)
    found = subject.step(batch)
    np.testing.assert_allclose(found.losses, [loss.item() for loss in expected.values()], rtol=1e-5)
    gradients = plain_networks.gradients(torch.stack(list(expected.values())).sum(), online)
    assert gradients.keys() == subject.gradients.keys()
    assert_close(subject.gradients, gradients, rtol=1e-4, atol=2e-5)


@VARIANTS
def test_the_largest_value_is_that_of_any_choice_at_the_states(name: str, config: dict[str, Any]) -> None:
    subject = Subject(name, **config)
    batch, online = subject.batch(), subject.online
    step = plain_learning.transitions(batch.rows[batch.indices])
    states, options = torch.from_numpy(step.observations).double(), torch.from_numpy(step.options)
    for level, largest in zip(subject.levels, subject.step(batch).largest, strict=True):
        read = options if subject.method.hierarchical and level == "action" else None
        values = plain_learning.values(subject.method, online, level, states, read)
        assert largest == pytest.approx(values.abs().max().item(), rel=1e-5)


@VARIANTS
@pytest.mark.parametrize("max_norm", [0.1, 1e9])
def test_one_step_is_one_of_adam(name: str, config: dict[str, Any], max_norm: float) -> None:
    """The gradient of every level has a bound of its own."""
    subject = Subject(name, **config)
    theirs = descended(subject, [subject.weighted()], [1e-2], max_norm)
    subject.step(subject.weighted(), 1e-2, max_norm)
    assert_close(subject.named(subject.learner.parameters.online), theirs, rtol=1e-5, atol=2e-5)


@VARIANTS
def test_a_hundred_steps_are_those_of_adam(name: str, config: dict[str, Any]) -> None:
    subject = Subject(name, **config)
    batches, rates = [subject.weighted(seed) for seed in range(100)], [1e-3 / (1.0 + 0.1 * k) for k in range(100)]
    before, target = subject.learner.parameters.online.copy(), subject.learner.parameters.target.copy()
    theirs = descended(subject, batches, rates, max_norm=5.0)
    for batch, rate in zip(batches, rates, strict=True):
        subject.step(batch, rate, max_norm=5.0)
    assert np.abs(subject.learner.parameters.online - before).max() > 0.005
    assert_close(subject.named(subject.learner.parameters.online), theirs, rtol=1e-4, atol=2e-5)
    np.testing.assert_array_equal(subject.learner.parameters.target, target)


def descended(subject: Subject, batches: list[Batch], rates: list[float], max_norm: float) -> plain_networks.Leaves:
    """The parameters after a step of torch's Adam down each of these batches, float64."""
    online = subject.online
    levels = {level: list(plain_networks.below(online, f"{level}.").values()) for level in subject.levels}
    optimiser = torch.optim.Adam([leaf for leaves in levels.values() for leaf in leaves], eps=1e-8)
    for batch, rate in zip(batches, rates, strict=True):
        optimiser.zero_grad()
        torch.stack(list(subject.expected_losses(batch, online).values())).sum().backward()  # type: ignore[no-untyped-call]
        for leaves in levels.values():
            torch.nn.utils.clip_grad_norm_(leaves, max_norm)
        optimiser.param_groups[0]["lr"] = rate
        optimiser.step()
    return online


@VARIANTS
def test_the_same_steps_give_the_same_bits(name: str, config: dict[str, Any]) -> None:
    first, second = Subject(name, **config), Subject(name, **config)
    for seed in range(5):
        ours, again = first.step(first.weighted(seed)), second.step(second.weighted(seed))
        for left, right in zip((*ours, *first.learner._memory), (*again, *second.learner._memory), strict=True):
            np.testing.assert_array_equal(left, right)


@pytest.mark.parametrize(("fixed", "learned"), [("option", "action"), ("action", "option")])
@pytest.mark.parametrize("config", [{}, {"memory": (0.1,), "advantage_learning": 0.5, "layer_norm": True}])
def test_a_fixed_level_chooses_and_does_not_move(fixed: str, learned: str, config: dict[str, Any]) -> None:
    subject = Subject("hybrid-hrl", fixed=(fixed,), **config)
    batch, online = subject.weighted(), subject.online
    expected = subject.expected_errors(batch, online)[learned]
    loss = subject.expected_losses(batch, online)[learned]
    theirs = descended(subject, [batch], [1e-2], 0.5)
    found = subject.step(batch, 1e-2, 0.5)
    own = slice(batch.firsts[0], batch.firsts[0] + batch.weights.shape[1])
    np.testing.assert_allclose(found.errors[0, own], expected.detach()[own], rtol=1e-4, atol=2e-5)
    assert found.losses == pytest.approx([loss.item()], rel=1e-5)
    assert_close(subject.named(subject.learner.parameters.online), theirs, rtol=1e-5, atol=2e-5)
    for name, value in subject.named(subject.learner.parameters.online).items():
        assert np.array_equal(value[0], online[name].detach().float()) == name.startswith(f"{fixed}.")
        assert subject.gradients[name].any() == name.startswith(f"{learned}.")


def test_a_terminal_step_s_target_is_its_reward() -> None:
    batch = Subject("hybrid-hrl").batch()
    features, ended, elsewhere = SIZE, batch.rows.copy(), batch.rows.copy()
    ended[:, 2 * features + 2] = elsewhere[:, 2 * features + 2] = 0.0
    elsewhere[:, features : 2 * features] += 3.0
    goes_on = batch.rows[batch.indices, 2 * features + 2] > 0
    assert goes_on.any()
    assert not goes_on.all()
    errors = [Subject("hybrid-hrl").step(batch._replace(rows=rows)).errors for rows in (ended, elsewhere, batch.rows)]
    for ours, same, other in zip(*errors, strict=True):
        np.testing.assert_array_equal(ours, same)
        np.testing.assert_array_equal(ours[~goes_on], other[~goes_on])
        assert (ours != other)[goes_on].all()


def test_what_one_level_is_rewarded_with_leaves_the_other_one_alone() -> None:
    batch = Subject("hybrid-hrl").batch()
    rows, subjects = batch.rows.copy(), [Subject("hybrid-hrl") for _ in range(2)]
    rows[:, 2 * SIZE + ACTION] += 10.0
    found = [s.step(b, max_norm=0.1) for s, b in zip(subjects, (batch, batch._replace(rows=rows)), strict=True)]
    np.testing.assert_array_equal(found[0].errors[OPTION], found[1].errors[OPTION])
    assert (found[0].errors[ACTION] != found[1].errors[ACTION]).all()
    first, second = (subject.named(subject.learner.parameters.online) for subject in subjects)
    for name, value in first.items():
        assert np.array_equal(value, second[name]) == name.startswith("option.")


def test_transitions_beyond_a_level_s_mini_batch_move_nothing() -> None:
    subject, other = Subject("hybrid-hrl"), Subject("hybrid-hrl")
    batch = subject.weighted()
    batch = batch._replace(indices=np.arange(K), firsts=np.zeros(2, np.int64))
    rows = batch.rows.copy()
    own = batch.weights.shape[1]
    rows[own:, : 2 * SIZE + 2] += 10.0
    first, second = subject.step(batch), other.step(batch._replace(rows=rows))
    assert first.errors[:, :own].all()
    np.testing.assert_array_equal(first.errors[:, :own], second.errors[:, :own])
    np.testing.assert_array_equal(first.losses, second.losses)
    np.testing.assert_array_equal(subject.learner.parameters.online, other.learner.parameters.online)


@pytest.mark.parametrize("alpha", [0.0, 0.5])
def test_a_masked_option_is_neither_chosen_nor_bootstrapped_from(alpha: float) -> None:
    subject = Subject("hrl-0", ALONE, advantage_learning=alpha)
    batch = subject.batch()
    step, online, target = plain_learning.transitions(batch.rows[batch.indices]), subject.online, subject.target
    options, _ = choices(subject, step.observations)
    assert not options.any()
    assert list(level_choices(ALONE)["option"]) == [0]
    states, following = (torch.from_numpy(s).double() for s in (step.observations, step.next_observations))
    values = plain_learning.values(subject.method, online, "option", states)
    assert (values.argmax(1) == 1).any()
    aims = plain_learning.values(subject.method, target, "option", following)[:, 0]
    lagged, taken = plain_learning.values(subject.method, target, "option", states), torch.from_numpy(step.options)
    rows = torch.arange(K)
    short = lagged[:, 0] - lagged[rows, taken]
    wanted = torch.from_numpy(step.rewards[:, OPTION]) + torch.from_numpy(step.discounts) * aims - alpha * short
    found = subject.step(batch).errors[OPTION]
    np.testing.assert_allclose(found, (wanted - values[rows, taken]).detach(), rtol=1e-4, atol=1e-5)


def choices(subject: Subject, states: Floats32, *tried: Ints) -> tuple[Ints, Ints]:
    """What a learner chooses at these states, given what each level tries; nothing by default."""
    subject.learner._environments.features = states
    return subject.learner._choose(dict(zip(subject.levels, tried, strict=False)))


def test_greedy_choices_have_the_highest_values_and_tried_ones_are_kept() -> None:
    subject, rng, count = Subject("hybrid-hrl"), np.random.default_rng(0), 50
    states = rng.normal(size=(count, SIZE)).astype(np.float32)
    tried = [rng.integers(GREEDY, len(level), count) for level in level_choices(MAIN).values()]
    options, actions = choices(subject, states, *tried)
    online, s = subject.online, torch.from_numpy(states).double()
    best = plain_learning.values(subject.method, online, "option", s).argmax(1).numpy()
    np.testing.assert_array_equal(options, np.where(tried[OPTION] == GREEDY, best, tried[OPTION]))
    best = plain_learning.values(subject.method, online, "action", s, torch.from_numpy(options)).argmax(1).numpy()
    np.testing.assert_array_equal(actions, np.where(tried[ACTION] == GREEDY, best, tried[ACTION]))


def test_a_flat_method_selects_no_option() -> None:
    options, actions = choices(Subject("ddqn"), np.zeros((K, SIZE), np.float32))
    assert (options == -1).all()
    assert actions.shape == (K,)
