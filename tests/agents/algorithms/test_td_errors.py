from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor

from hhrl_agents import METHODS
from hhrl_agents.agent import ACTION, OPTION
from hhrl_agents.algorithms.td_errors import Algorithm, make_algorithm
from hhrl_agents.networks.architectures import method_shapes
from hhrl_agents.networks.parameters import ParameterStack
from hhrl_agents.replay.buffer import MiniBatch
from hhrl_agents.seeding import Purpose, generators
from hhrl_agents.training.exploration import GREEDY, level_choices
from hhrl_envs import Scenario, get_scenario
from hhrl_envs.observation import SIZE
from support import plain_networks

MAIN = get_scenario("stop-line-v0")
ALONE = replace(MAIN, id="alone", traffic=replace(MAIN.traffic, count_shares=(1.0,)))
SEEDS = (4, 9)
SIZE_K = 7
VARIANTS = pytest.mark.parametrize(
    ("name", "config"),
    [
        ("ddqn", {}),
        ("ddqn", {"layer_norm": True}),
        ("hrl-0", {}),
        ("hybrid-hrl", {}),
        ("hybrid-hrl", {"attended": "linear"}),
        ("hybrid-hrl", {"layer_norm": True}),
        ("hybrid-hrl", {"sees_line": False, "advantage_learning": 0.9}),
        ("hybrid-hrl", {"memory": (0.1, 0.03), "advantage_learning": 0.5}),
        ("ddqn", {"memory": (0.5,), "advantage_learning": 0.3, "layer_norm": True}),
    ],
)


class Subject:
    """An algorithm whose target networks differ from the online ones, and a plain reference of each seed's values."""

    def __init__(self, name: str, scenario: Scenario = MAIN, **config: Any) -> None:
        method = METHODS[name]
        method = replace(method, config=replace(method.config, hidden=(16, 12), **config))
        shapes, streams = method_shapes(method, scenario.num_actions), generators(SEEDS, Purpose.INITIALISATION)
        self.features, self.alpha = method.config.features, method.config.advantage_learning
        plain = ("attended", "layer_norm", "sees_line")
        self.config = {name: config[name] for name in plain if name in config}
        self.stack = ParameterStack(shapes, streams, torch.device("cpu"))
        rng = np.random.default_rng(1)
        for flat in (self.stack.flat, self.stack.flat_target):
            flat.add_(torch.from_numpy(rng.normal(0.0, 0.2, tuple(flat.shape)).astype(np.float32)))
        self.algorithm: Algorithm = make_algorithm(method, scenario, self.stack, {})

    def leaves(self, level: str, e: int, *, target: bool = False) -> plain_networks.Leaves:
        return plain_networks.leaves(self.stack.both, e + target * len(SEEDS), f"{level}.")

    def values(self, leaves: plain_networks.Leaves, s: Tensor, options: Tensor | None = None) -> Tensor:
        """One level's values [K, C] of the states [K, features]; `options` [K] for the action level of a hierarchy."""
        if options is None:
            return plain_networks.mlp(leaves, s, layer_norm=self.config.get("layer_norm", False))
        return plain_networks.action_values(leaves, s, torch.eye(2).double()[options], **self.config)


def batch_of(rng: np.random.Generator, size: int = SIZE) -> MiniBatch:
    def normal(features: int) -> Tensor:
        return torch.from_numpy(rng.normal(size=(len(SEEDS), features, SIZE_K)).astype(np.float32))

    shape = (len(SEEDS), 1, SIZE_K)
    return MiniBatch(
        observations=normal(size),
        options=torch.from_numpy(rng.integers(0, 2, shape)),
        actions=torch.from_numpy(rng.integers(0, MAIN.num_actions, shape)),
        option_rewards=normal(1),
        action_rewards=normal(1),
        discounts=torch.from_numpy(rng.choice([0.0, 0.97], shape).astype(np.float32)),
        next_observations=normal(size),
    )


def expected_errors(subject: Subject, batch: MiniBatch, e: int) -> list[tuple[Tensor, plain_networks.Leaves]]:
    """The errors Y - Q of each level, [K], written out sample by sample, and the leaves that Q depends on.

    Advantage learning takes alpha (max Q' - Q') of the target network at the states themselves off Y.
    """
    s, following = plain_networks.rows(batch.observations, e), plain_networks.rows(batch.next_observations, e)
    given: dict[str, Tensor | None] = {"option": None, "action": None}
    best: dict[str, Tensor | None] = {"option": None, "action": None}
    rewards = {"option": batch.option_rewards, "action": batch.action_rewards}
    chosen = {"option": batch.options[e, 0], "action": batch.actions[e, 0]}
    found = []
    for level in subject.algorithm.levels:
        if level == "action" and "option" in subject.algorithm.levels:
            given = {**given, "action": batch.options[e, 0]}
        online, target = subject.leaves(level, e), subject.leaves(level, e, target=True)
        star = subject.values(online, following, best[level]).argmax(1)
        if level == "option":
            best["action"] = star
        values, aims = subject.values(online, s, given[level]), subject.values(target, following, best[level])
        here = subject.values(target, s, given[level]).detach()
        errors = [
            rewards[level][e, 0, k].double()
            + batch.discounts[e, 0, k].double() * aims[k, star[k]].detach()
            - subject.alpha * (here[k].max() - here[k, chosen[level][k]])
            - values[k, chosen[level][k]]
            for k in range(SIZE_K)
        ]
        found.append((torch.stack(errors), online))
    return found


@VARIANTS
def test_errors_are_those_of_double_dqn_at_every_level(name: str, config: dict[str, Any]) -> None:
    subject = Subject(name, **config)
    batch = batch_of(np.random.default_rng(0), subject.features)
    levels = subject.algorithm.td_errors(batch)
    for e in range(len(SEEDS)):
        for level, (errors, _) in zip(levels, expected_errors(subject, batch, e), strict=True):
            np.testing.assert_allclose(level.errors[e, 0], errors.detach(), rtol=1e-4, atol=1e-4)


def test_a_terminal_step_s_target_is_its_reward() -> None:
    subject, batch = Subject("hybrid-hrl"), batch_of(np.random.default_rng(0))
    ended = batch._replace(discounts=torch.zeros_like(batch.discounts))
    elsewhere = ended._replace(next_observations=ended.next_observations + 3.0)
    for ours, same, other in zip(*(subject.algorithm.td_errors(b) for b in (ended, elsewhere, batch)), strict=True):
        assert torch.equal(ours.errors, same.errors)
        goes_on = batch.discounts > 0
        assert torch.equal(ours.errors[~goes_on], other.errors[~goes_on])
        assert (ours.errors != other.errors)[goes_on].all()


@VARIANTS
@pytest.mark.parametrize("part", [slice(0, SIZE_K), slice(2, 5)])
def test_losses_and_gradients_are_the_weighted_squared_errors(name: str, config: dict[str, Any], part: slice) -> None:
    subject = Subject(name, **config)
    batch = batch_of(np.random.default_rng(0), subject.features)
    size = part.stop - part.start
    weights = torch.from_numpy(np.random.default_rng(3).random((len(SEEDS), 1, size)).astype(np.float32))
    losses = [level.backward(part, weights) for level in subject.algorithm.td_errors(batch)]
    for e in range(len(SEEDS)):
        expected = expected_errors(subject, batch, e)
        for level, ours, (errors, leaves) in zip(subject.algorithm.levels, losses, expected, strict=True):
            loss = (weights[e, 0].double() * errors[part].square()).mean()
            assert ours[e] == pytest.approx(loss.item(), rel=1e-4)
            for key, gradient in plain_networks.gradients(loss, leaves).items():
                mine = subject.stack.gradients[f"{level}.{key}"][e]
                np.testing.assert_allclose(mine, gradient, rtol=1e-3, atol=1e-4, err_msg=key)


def test_levels_do_not_mix() -> None:
    subject = Subject("hybrid-hrl")
    everything = slice(0, SIZE_K)
    for level in subject.algorithm.td_errors(batch_of(np.random.default_rng(0))):
        subject.stack.gradient.fill_(7.0)
        level.backward(everything, torch.ones(len(SEEDS), 1, SIZE_K))
        touched = {name.split(".")[0] for name, value in subject.stack.gradients.items() if (value != 7.0).any()}
        assert len(touched) == 1


def test_a_masked_option_is_neither_chosen_nor_bootstrapped_from() -> None:
    subject, batch = Subject("hrl-0", ALONE), batch_of(np.random.default_rng(0))
    greedy = np.full((len(SEEDS), SIZE_K), GREEDY)
    observations = batch.observations.transpose(1, 2).numpy()
    options, _ = subject.algorithm.choose(observations, (greedy, greedy))
    assert not options.any()
    assert list(level_choices(ALONE)["option"]) == [0]
    option, _ = subject.algorithm.td_errors(batch)
    for e in range(len(SEEDS)):
        online, target = subject.leaves("option", e), subject.leaves("option", e, target=True)
        aim = subject.values(target, plain_networks.rows(batch.next_observations, e))[:, 0]
        values = subject.values(online, plain_networks.rows(batch.observations, e))
        taken = values.gather(1, batch.options[e].T)[:, 0]
        expected = batch.option_rewards[e, 0] + batch.discounts[e, 0] * aim - taken
        np.testing.assert_allclose(option.errors[e, 0], expected.detach(), rtol=1e-4, atol=1e-5)


def test_greedy_choices_have_the_highest_values_and_tried_ones_are_kept() -> None:
    subject, rng = Subject("hybrid-hrl"), np.random.default_rng(0)
    observations = rng.normal(size=(len(SEEDS), SIZE_K, SIZE)).astype(np.float32)
    tried = [rng.integers(GREEDY, len(choices), (len(SEEDS), SIZE_K)) for choices in level_choices(MAIN).values()]
    options, actions = subject.algorithm.choose(observations, tried)
    for e in range(len(SEEDS)):
        s = torch.from_numpy(observations[e]).double()
        option = subject.values(subject.leaves("option", e), s).argmax(1).numpy()
        np.testing.assert_array_equal(options[e], np.where(tried[OPTION][e] == GREEDY, option, tried[OPTION][e]))
        action = subject.values(subject.leaves("action", e), s, torch.from_numpy(options[e])).argmax(1).numpy()
        np.testing.assert_array_equal(actions[e], np.where(tried[ACTION][e] == GREEDY, action, tried[ACTION][e]))


def test_a_flat_algorithm_selects_no_option() -> None:
    subject = Subject("ddqn")
    observations = np.zeros((len(SEEDS), SIZE_K, SIZE), np.float32)
    options, actions = subject.algorithm.choose(observations, (np.full((len(SEEDS), SIZE_K), GREEDY),))
    assert (options == -1).all()
    assert actions.shape == (len(SEEDS), SIZE_K)
