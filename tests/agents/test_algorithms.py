from dataclasses import replace

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from hhrl_agents import METHODS
from hhrl_agents.algorithms import Algorithm, DoubleDQN, HierarchicalDoubleDQN, double_q
from hhrl_agents.exploration import GREEDY
from hhrl_agents.networks import subset
from hhrl_agents.replay import ACTION, OPTION, Batch
from hhrl_agents.seeding import Purpose, generators
from hhrl_envs import Scenario, get_scenario
from hhrl_envs.observation import SIZE

MAIN = get_scenario("stop-line-v0")
ALONE = replace(MAIN, id="alone", traffic=replace(MAIN.traffic, count_shares=(1.0,)))
SEEDS = (4, 9)
SIZE_K = 7
Array = NDArray[np.float32]
Arrays = dict[str, Array]


def algorithm_of(name: str, scenario: Scenario = MAIN) -> Algorithm:
    """An algorithm whose target networks are those of other seeds than the online ones."""
    method, streams = METHODS[name], generators(SEEDS, Purpose.INITIALISATION)
    made = (HierarchicalDoubleDQN if method.hierarchical else DoubleDQN)(method, scenario, streams)
    rng = np.random.default_rng(1)
    with torch.no_grad():
        for stack in made.stacks.values():
            stack.flat.add_(torch.from_numpy(rng.normal(0.0, 0.2, tuple(stack.flat.shape)).astype(np.float32)))
    return made


def batch_of(rng: np.random.Generator) -> Batch:
    shape = (len(SEEDS), SIZE_K)
    return Batch(
        observations=torch.from_numpy(rng.normal(size=(*shape, SIZE)).astype(np.float32)),
        options=torch.from_numpy(rng.integers(0, 2, shape)),
        actions=torch.from_numpy(rng.integers(0, MAIN.num_actions, shape)),
        rewards=torch.from_numpy(rng.normal(size=(2, *shape)).astype(np.float32)),
        discounts=torch.from_numpy(rng.choice([0.0, 0.97], shape).astype(np.float32)),
        next_observations=torch.from_numpy(rng.normal(size=(*shape, SIZE)).astype(np.float32)),
    )


def networks(algorithm: Algorithm, level: str, e: int) -> tuple[Arrays, Arrays]:
    """Online and target parameters of one seed's network in numpy."""
    both = algorithm.stacks[level].both
    online = {name: value[e].numpy() for name, value in both.items()}
    return online, {name: value[e + len(SEEDS)].numpy() for name, value in both.items()}


def mlp(p: Arrays, x: Array) -> Array:
    for layer in range(3):
        x = x @ p[f"{layer}.weight"] + p[f"{layer}.bias"]
        x = np.maximum(x, 0) if layer < 2 else x
    return x


def q_action(p: Arrays, s: Array, option: int) -> Array:
    o = np.eye(2, dtype=np.float32)[option]
    if "attention.state.weight" in p:
        scores = (s @ p["attention.state.weight"] + p["attention.state.bias"])[0] + o @ p["attention.option.weight"]
        s = (SIZE * np.exp(scores) / np.exp(scores).sum() * s).astype(np.float32)
    values = {name.removeprefix("values."): value for name, value in p.items() if name.startswith("values.")}
    value: Array = mlp(values, np.concatenate((s, o)))[0]
    return value


def test_double_q_takes_the_target_s_value_of_the_online_s_choice() -> None:
    online, target = torch.tensor([[[1.0, 5.0, 2.0]]]), torch.tensor([[[10.0, 20.0, 30.0]]])
    best, value = double_q(torch.cat((online, target)))
    assert (best.item(), value.item()) == (1, 20.0)


def test_flat_errors_are_those_of_double_dqn() -> None:
    algorithm, batch = algorithm_of("ddqn"), batch_of(np.random.default_rng(0))
    (errors,) = algorithm.td_errors(batch)
    for e in range(len(SEEDS)):
        online, target = networks(algorithm, "action", e)
        for k in range(SIZE_K):
            s, following = batch.observations[e, k].numpy(), batch.next_observations[e, k].numpy()
            best = mlp(online, following)[0].argmax()
            reward, discount = batch.rewards[ACTION, e, k].item(), batch.discounts[e, k].item()
            expected = reward + discount * mlp(target, following)[0][best] - mlp(online, s)[0][batch.actions[e, k]]
            np.testing.assert_allclose(errors[e, k].item(), expected, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("name", ["hrl-0", "hybrid-hrl"])
def test_hierarchical_errors_are_those_of_the_paper(name: str) -> None:
    algorithm, batch = algorithm_of(name), batch_of(np.random.default_rng(0))
    option_errors, action_errors = algorithm.td_errors(batch)
    for e in range(len(SEEDS)):
        option_online, option_target = networks(algorithm, "option", e)
        action_online, action_target = networks(algorithm, "action", e)
        for k in range(SIZE_K):
            s, following = batch.observations[e, k].numpy(), batch.next_observations[e, k].numpy()
            option, action = int(batch.options[e, k]), int(batch.actions[e, k])
            discount = batch.discounts[e, k].item()
            best_option = int(mlp(option_online, following)[0].argmax())
            y_option = batch.rewards[OPTION, e, k].item() + discount * mlp(option_target, following)[0][best_option]
            best_action = q_action(action_online, following, best_option).argmax()
            next_value = q_action(action_target, following, best_option)[best_action]
            y_action = batch.rewards[ACTION, e, k].item() + discount * next_value
            expected = (
                y_option - mlp(option_online, s)[0][option],
                y_action - q_action(action_online, s, option)[action],
            )
            np.testing.assert_allclose(option_errors[e, k].item(), expected[0], rtol=1e-4, atol=1e-5)
            np.testing.assert_allclose(action_errors[e, k].item(), expected[1], rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("name", ["ddqn", "hybrid-hrl"])
def test_targets_carry_no_gradient_and_levels_do_not_mix(name: str) -> None:
    algorithm = algorithm_of(name)
    errors = algorithm.td_errors(batch_of(np.random.default_rng(0)))
    for error, (level, stack) in zip(errors, algorithm.stacks.items(), strict=True):
        for other, elsewhere in algorithm.stacks.items():
            leaves = list(elsewhere.online.values())
            parts = torch.autograd.grad(error.sum(), leaves, retain_graph=True, allow_unused=True)
            assert all((part is not None) == (other == level) for part in parts)
        assert not any(value.requires_grad for value in stack.both.values())


def test_a_masked_option_is_neither_chosen_nor_bootstrapped_from() -> None:
    algorithm, batch = algorithm_of("hrl-0", ALONE), batch_of(np.random.default_rng(0))
    observations = batch.observations.numpy()
    greedy = np.full((len(SEEDS), SIZE_K), GREEDY)
    options, _ = algorithm.choose(observations, (greedy, greedy))
    assert not options.any()
    assert list(algorithm.choices[OPTION]) == [0]
    option_errors, _ = algorithm.td_errors(batch)
    for e in range(len(SEEDS)):
        online, target = networks(algorithm, "option", e)
        for k in range(SIZE_K):
            next_value = mlp(target, batch.next_observations[e, k].numpy())[0][0]
            y = batch.rewards[OPTION, e, k].item() + batch.discounts[e, k].item() * next_value
            expected = y - mlp(online, observations[e, k])[0][batch.options[e, k]]
            np.testing.assert_allclose(option_errors[e, k].item(), expected, rtol=1e-4, atol=1e-5)


def test_greedy_choices_have_the_highest_values_and_tried_ones_are_kept() -> None:
    algorithm, rng = algorithm_of("hybrid-hrl"), np.random.default_rng(0)
    observations = rng.normal(size=(len(SEEDS), SIZE_K, SIZE)).astype(np.float32)
    tried = [rng.integers(GREEDY, len(choices), (len(SEEDS), SIZE_K)) for choices in algorithm.choices]
    options, actions = algorithm.choose(observations, tried)
    for e in range(len(SEEDS)):
        option_online, _ = networks(algorithm, "option", e)
        action_online, _ = networks(algorithm, "action", e)
        for k in range(SIZE_K):
            s = observations[e, k]
            option = tried[OPTION][e, k] if tried[OPTION][e, k] != GREEDY else mlp(option_online, s)[0].argmax()
            greedy_action = q_action(action_online, s, int(option)).argmax()
            assert options[e, k] == option
            assert actions[e, k] == (tried[ACTION][e, k] if tried[ACTION][e, k] != GREEDY else greedy_action)


def test_a_flat_algorithm_selects_no_option() -> None:
    algorithm = algorithm_of("ddqn")
    observations = np.zeros((len(SEEDS), SIZE_K, SIZE), np.float32)
    options, _ = algorithm.choose(observations, (np.full((len(SEEDS), SIZE_K), GREEDY),))
    assert (options == -1).all()
    assert not subset(algorithm.stacks["action"].online, "attention.")
