"""Methods that learn one level alone: what is given, the targets of what is learned, and checkpoints of both."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from hhrl_agents import METHODS, RULES
from hhrl_agents.algorithms.td_errors import Algorithm, LevelErrors, make_algorithm
from hhrl_agents.networks.architectures import method_shapes
from hhrl_agents.networks.parameters import ParameterStack
from hhrl_agents.policies import checkpoint_file, checkpoints
from hhrl_agents.policies.checkpoints import frozen_parameters
from hhrl_agents.policies.learned_agent import HierarchicalLearnedAgent, make_agent
from hhrl_agents.replay.buffer import MiniBatch
from hhrl_agents.seeding import Purpose, generators
from hhrl_agents.training.exploration import GREEDY
from hhrl_envs import InputError, Option, Simulator, get_scenario
from hhrl_envs.observation import D_D, SIZE

MAIN = get_scenario("stop-line-v0")
SEEDS = (4, 9)
COUNT = 40
Array = NDArray[np.float32]
Leaves = dict[str, Array]


def algorithm_of(name: str) -> tuple[Algorithm, ParameterStack]:
    """An algorithm whose target networks differ from the online ones."""
    method = METHODS[name]
    shapes, streams = method_shapes(method, MAIN.num_actions), generators(SEEDS, Purpose.INITIALISATION)
    stack = ParameterStack(shapes, streams, torch.device("cpu"))
    stack.flat_target.add_(torch.from_numpy(np.random.default_rng(1).normal(0.0, 0.1, stack.flat_target.shape)))
    return make_algorithm(method, MAIN, stack, frozen_parameters(method)), stack


def observations_of(rows: int) -> Array:
    """States of driven worlds, so that rules select either option, float32 [rows, 11]."""
    simulator = Simulator(MAIN, rows)
    simulator.reset(np.arange(rows))
    rng = np.random.default_rng(3)
    for _ in range(60):
        simulator.step(rng.integers(2, MAIN.num_actions, rows))
        simulator.reset_done()
    return simulator.observations.copy()


def batch_of() -> MiniBatch:
    rng, shape = np.random.default_rng(0), (len(SEEDS), 1, COUNT)
    states = [observations_of(len(SEEDS) * COUNT).reshape(len(SEEDS), COUNT, SIZE) for _ in range(2)]
    now, following = (torch.from_numpy(part).transpose(1, 2) for part in (states[0], states[1][:, ::-1].copy()))
    r_option, r_action = (torch.from_numpy(rng.normal(size=shape).astype(np.float32)) for _ in range(2))
    options, actions = (torch.from_numpy(rng.integers(0, count, shape)) for count in (2, MAIN.num_actions))
    discounts = torch.from_numpy(rng.choice([0.0, 0.97], shape).astype(np.float32))
    return MiniBatch(now, options, actions, r_option, r_action, discounts, following)


def leaves(stack: ParameterStack, level: str, row: int) -> Leaves:
    """One seed's online parameters, or the target ones behind all seeds' online ones."""
    named = {name: value[row].numpy() for name, value in stack.both.items()}
    return {name.removeprefix(f"{level}."): value for name, value in named.items() if name.startswith(f"{level}.")}


def mlp(p: Leaves, x: Array) -> Array:
    for layer in range(3):
        x = x @ p[f"{layer}.weight"] + p[f"{layer}.bias"]
        x = np.maximum(x, 0) if layer < 2 else x
    return x


def action_values(p: Leaves, s: Array, options: NDArray[np.int64], *, sees_line: bool = True) -> Array:
    """Q^a, [K, A], for states [K, 11]."""
    chosen = np.eye(2, dtype=np.float32)[options]
    if not sees_line:
        s = np.where(np.arange(SIZE) < D_D, s, np.float32(0))
    if "attention.state.weight" in p:
        scores = s @ p["attention.state.weight"] + p["attention.state.bias"] + chosen @ p["attention.option.weight"]
        powers = np.exp(scores - scores.max(-1, keepdims=True))
        s = SIZE * powers / powers.sum(-1, keepdims=True) * s
    values = {name.removeprefix("values."): value for name, value in p.items() if name.startswith("values.")}
    return mlp(values, np.concatenate((s, chosen), -1))


def at(values: Array, choices: NDArray[np.int64]) -> Array:
    chosen: Array = np.take_along_axis(values, choices[:, None], 1)[:, 0]
    return chosen


@pytest.mark.parametrize(("name", "rule"), [("follow-only", "rule-1"), ("rule-option", "rule-4")])
def test_action_targets_follow_the_option_given_at_the_next_state(name: str, rule: str) -> None:
    (algorithm, stack), batch = algorithm_of(name), batch_of()
    (errors,) = algorithm.td_errors(batch)
    sees_line = METHODS[name].config.sees_line
    for e in range(len(SEEDS)):
        online, target = leaves(stack, "action", e), leaves(stack, "action", e + len(SEEDS))
        states, following = batch.observations[e].T.numpy(), batch.next_observations[e].T.numpy()
        given = RULES[rule](MAIN).act(following).option
        assert len(set(given)) == (1 if rule == "rule-1" else 2)
        best = action_values(online, following, given, sees_line=sees_line).argmax(1)
        value = at(action_values(target, following, given, sees_line=sees_line), best)
        held = action_values(online, states, batch.options[e, 0].numpy(), sees_line=sees_line)
        y = batch.action_rewards[e, 0].numpy() + batch.discounts[e, 0].numpy() * value
        expected = y - at(held, batch.actions[e, 0].numpy())
        np.testing.assert_allclose(errors.errors[e, 0].numpy(), expected, rtol=1e-4, atol=1e-5)


def test_option_targets_do_not_ask_for_actions() -> None:
    (algorithm, stack), batch = algorithm_of("option-only"), batch_of()
    (errors,) = algorithm.td_errors(batch)
    for e in range(len(SEEDS)):
        online, target = leaves(stack, "option", e), leaves(stack, "option", e + len(SEEDS))
        states, following = batch.observations[e].T.numpy(), batch.next_observations[e].T.numpy()
        value = at(mlp(target, following), mlp(online, following).argmax(1))
        y = batch.option_rewards[e, 0].numpy() + batch.discounts[e, 0].numpy() * value
        expected = y - at(mlp(online, states), batch.options[e, 0].numpy())
        np.testing.assert_allclose(errors.errors[e, 0].numpy(), expected, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("name", ["follow-only", "option-only", "rule-option"])
def test_all_that_is_learned_gets_a_gradient(name: str) -> None:
    algorithm, stack = algorithm_of(name)
    errors: tuple[LevelErrors, ...] = algorithm.td_errors(batch_of())
    assert len(errors) == len(algorithm.levels) == 1
    errors[0].backward(slice(0, COUNT), torch.ones((len(SEEDS), 1, COUNT)))
    assert all(gradient.any() for gradient in stack.gradients.values())


@pytest.mark.parametrize(("name", "rule"), [("follow-only", "rule-1"), ("rule-option", "rule-4")])
def test_given_options_are_the_rule_s_and_tried_actions_are_kept(name: str, rule: str) -> None:
    algorithm, _ = algorithm_of(name)
    observations = observations_of(len(SEEDS) * COUNT)
    tried = np.random.default_rng(0).integers(GREEDY, MAIN.num_actions, (len(SEEDS), COUNT))
    options, actions = algorithm.choose(observations.reshape(len(SEEDS), COUNT, SIZE), (tried,))
    np.testing.assert_array_equal(options.reshape(-1), RULES[rule](MAIN).act(observations).option)
    np.testing.assert_array_equal(actions[tried != GREEDY], tried[tried != GREEDY])


def test_given_actions_stop_by_the_controller_and_follow_by_the_trained_policy() -> None:
    algorithm, _ = algorithm_of("option-only")
    observations = observations_of(len(SEEDS) * COUNT)
    tried = np.random.default_rng(0).integers(0, 2, (len(SEEDS), COUNT))
    options, actions = algorithm.choose(observations.reshape(len(SEEDS), COUNT, SIZE), (tried,))
    np.testing.assert_array_equal(options, tried)
    stop = RULES["rule-2"](MAIN).act(observations).action
    follower = checkpoints.load(checkpoint_file.SHIPPED / "follow-only" / "seed-0.safetensors")
    assert isinstance(follower, HierarchicalLearnedAgent)
    follow = follower.act_with_option(observations, np.ones(len(observations), np.int64))
    assert (stop != follow).any()
    np.testing.assert_array_equal(actions.reshape(-1), np.where(tried.reshape(-1) == Option.FFV, follow, stop))


def test_a_follower_does_not_see_the_line() -> None:
    method = METHODS["follow-only"]
    _, stack = algorithm_of("follow-only")
    agent = make_agent(method, MAIN, stack.snapshot(0), {})
    seen, elsewhere = observations_of(COUNT), observations_of(COUNT)
    elsewhere[:, D_D:] = np.random.default_rng(0).normal(size=(COUNT, SIZE - D_D))
    np.testing.assert_array_equal(agent.act(seen).action, agent.act(elsewhere).action)
    blind = make_agent(replace(method, config=replace(method.config, sees_line=True)), MAIN, stack.snapshot(0), {})
    assert (blind.act(seen).action != blind.act(elsewhere).action).any()


def test_what_is_given_has_no_attention() -> None:
    _, stack = algorithm_of("option-only")
    method = METHODS["option-only"]
    agent = make_agent(method, MAIN, {**stack.snapshot(0), **frozen_parameters(method)}, {})
    assert isinstance(agent, HierarchicalLearnedAgent)
    with pytest.raises(InputError, match="action level is given"):
        agent.attention(observations_of(3), np.zeros(3, np.int64))


def test_a_missing_follower_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert frozen_parameters(METHODS["hybrid-hrl"]) == {}
    other = replace(METHODS["option-only"], ffv=replace(METHODS["follow-only"], attention=True))
    with pytest.raises(InputError, match="another config; train that again"):
        frozen_parameters(other)
    monkeypatch.setattr(checkpoint_file, "SHIPPED", tmp_path)
    with pytest.raises(InputError, match="no such file"):
        frozen_parameters(METHODS["option-only"])
