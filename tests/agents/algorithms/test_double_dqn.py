from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from hhrl_agents import METHODS
from hhrl_agents.algorithms.double_dqn import DoubleDQNLearner
from hhrl_agents.methods.configs import linear_schedule
from hhrl_agents.methods.method import Method
from hhrl_agents.policies.learned_agent import LearnedAgent
from hhrl_agents.policies.observation_memory import Traces
from hhrl_agents.replay.buffer import MiniBatch
from hhrl_agents.training.environments import learning_rewards
from hhrl_agents.training.exploration import GREEDY
from hhrl_agents.training.learner import Progress
from hhrl_envs import InputError, Outcome, Scenario, Simulator, get_scenario
from hhrl_envs.observation import SIZE
from hhrl_envs.simulation.rewards import TIMEOUT, UNSMOOTH

MAIN = get_scenario("stop-line-v0")
NAMES = [name for name, method in METHODS.items() if method.algorithm == "double-dqn"]
N_ENVS = 4
SMALL: dict[str, Any] = {
    "hidden": (16, 16),
    "n_envs": N_ENVS,
    "batch_size": 8,
    "replay_capacity": 2_000,
    "warmup": 40,
    "steps_per_update": 4,
    "target_interval": 10,
    "report_every": 100,
}


def small(name: str, **values: Any) -> Method:
    method = METHODS[name]
    return replace(method, config=replace(method.config, **{**SMALL, **values}))


def learner_of(method: Method, seeds: Sequence[int] = (3, 5), scenario: Scenario = MAIN) -> DoubleDQNLearner:
    n_envs = method.config.n_envs
    worlds = np.array(seeds)[:, None] * n_envs + np.arange(n_envs)
    return DoubleDQNLearner(method, scenario, seeds, worlds.astype(np.uint64))


def trained(method: Method, seeds: Sequence[int] = (3, 5), steps: int = 400) -> tuple[DoubleDQNLearner, list[Progress]]:
    learner = learner_of(method, seeds)
    return learner, list(learner.train(steps))


def stored(learner: DoubleDQNLearner, count: int) -> MiniBatch:
    """The first `count` transitions of every seed."""
    indices = np.tile(np.arange(count), (len(learner.seeds), 1))
    return learner._replay.gather(indices)


def joined_steps(learner: DoubleDQNLearner, steps: int) -> int:
    """How many multi-step transitions every environment has after so many steps."""
    return steps - int(learner.method.config.n_steps) + 1


@pytest.mark.parametrize("name", NAMES)
def test_transitions_follow_each_other(name: str) -> None:
    steps, n_steps = 160, METHODS[name].config.n_steps
    learner, _ = trained(small(name, final_epsilon=1.0), steps=steps * N_ENVS)
    count = joined_steps(learner, steps)
    assert (learner._replay.stored == count * N_ENVS).all()
    batch, shape = stored(learner, count * N_ENVS), (2, count, N_ENVS, learner.method.config.features)
    first = batch.observations.transpose(1, 2).reshape(shape)
    second = batch.next_observations.transpose(1, 2).reshape(shape)
    goes_on = batch.discounts.reshape(shape[:3])[:, :-n_steps] > 0
    follows = (second[:, :-n_steps] == first[:, n_steps:]).all(-1)
    assert follows[goes_on].float().mean() > 0.99
    assert not follows[~goes_on].any()
    moved = (first != second).any(-1)
    assert moved.float().mean() > 0.9


class Played(NamedTuple):
    """What one step of every environment of a seed has been, by replaying its world."""

    features: NDArray[np.float32]
    rewards: NDArray[np.float64]
    discounts: NDArray[np.float64]
    next_features: NDArray[np.float32]
    ended: NDArray[np.bool_]


def level_rewards_of(method: Method, simulator: Simulator, options: NDArray[np.int64]) -> NDArray[np.float64]:
    """The rewards of both levels, [n, 2]; those without hybrid reward written out."""
    if method.hybrid_reward:
        return learning_rewards(method, simulator.of_agent(0), options)
    task = simulator.rewards - (1.0 - method.config.jerk_weight) * simulator.terms[:, UNSMOOTH]
    task = task - simulator.terms[:, TIMEOUT] if method.config.timeout == "truncation" else task
    rewards: NDArray[np.float64] = np.stack((task, task), axis=1) * method.config.reward_scale
    return rewards


def replayed(learner: DoubleDQNLearner, index: int, batch: MiniBatch) -> list[Played]:
    """Every step of a seed's worlds, driven as the stored transitions say."""
    method, played = learner.method, list[Played]()
    simulator, memory = Simulator(learner.scenario, N_ENVS), Traces(method.config.memory)
    simulator.reset(np.arange(N_ENVS) + learner.seeds[index] * N_ENVS)
    goes_on = {Outcome.RUNNING, Outcome.TIMEOUT} if method.config.timeout == "truncation" else {Outcome.RUNNING}
    features = memory.observe(simulator.observations.copy())
    for step in range(batch.actions.shape[2] // N_ENVS):
        columns = slice(step * N_ENVS, (step + 1) * N_ENVS)
        simulator.step(batch.actions[index, 0, columns].numpy())
        rewards = level_rewards_of(method, simulator, batch.options[index, 0, columns].numpy())
        discounts = np.where(np.isin(simulator.outcomes, list(goes_on)), method.config.gamma, 0.0)
        ended, following = simulator.outcomes != Outcome.RUNNING, memory.observe(simulator.observations.copy())
        played.append(Played(features, rewards, discounts, following, ended))
        simulator.reset_done()
        memory.begin(ended)
        features = memory.observe(simulator.observations.copy(), ended)
    return played


@pytest.mark.parametrize("name", NAMES)
def test_what_is_stored_are_the_simulator_s_steps_joined(name: str) -> None:
    """Also where the time limit cuts, every transition is the one that a plain loop over the replayed steps gives."""
    steps, scenario = 20, replace(MAIN, id="short", horizon=7, feasible_only=False)
    learner = learner_of(small(name, warmup=100), scenario=scenario)
    list(learner.train(steps * N_ENVS))
    count, n_steps = joined_steps(learner, steps), learner.method.config.n_steps
    batch = stored(learner, count * N_ENVS)
    for index in range(len(learner.seeds)):
        played = replayed(learner, index, batch)
        assert np.stack([step.ended for step in played]).any()
        for begin, env in np.ndindex(count - n_steps + 1, N_ENVS):
            k, total, discount = begin * N_ENVS + env, np.zeros(2), np.ones(())
            for step in played[begin : begin + n_steps]:
                total, discount = total + discount * step.rewards[env], discount * step.discounts[env]
                if step.ended[env]:
                    break
            found = [batch.option_rewards[index, 0, k].item(), batch.action_rewards[index, 0, k].item()]
            assert found == pytest.approx(total, rel=1e-5, abs=1e-6)
            assert batch.discounts[index, 0, k].item() == pytest.approx(discount, rel=1e-6)
            np.testing.assert_array_equal(batch.observations[index, :, k], played[begin].features[env])
            np.testing.assert_array_equal(batch.next_observations[index, :, k], step.next_features[env])


@pytest.mark.parametrize(
    ("name", "replay"),
    [("ddqn", "uniform"), ("ddqn", "prioritised"), ("hrl-0", "prioritised"), ("hybrid-hrl", "hierarchical")],
)
def test_a_seed_learns_the_same_alone_and_in_a_stack(name: str, replay: Any) -> None:
    method = replace(small(name, warmup=200), replay=replay)
    together, _ = trained(method, seeds=(3, 5, 8), steps=280)
    alone, _ = trained(method, seeds=(5,), steps=280)
    inside, outside = stored(together, 280), stored(alone, 280)
    assert torch.equal(inside.actions[1], outside.actions[0])
    assert torch.equal(inside.observations[1], outside.observations[0])
    assert together.updates == alone.updates == 20
    np.testing.assert_allclose(together.stack.flat[1], alone.stack.flat[0], rtol=1e-3, atol=2e-5)


@pytest.mark.parametrize("name", NAMES)
def test_the_same_stack_learns_the_same_bits(name: str) -> None:
    first, second = trained(small(name))[0], trained(small(name))[0]
    assert torch.equal(first.stack.flat, second.stack.flat)
    assert torch.equal(first.stack.flat_target, second.stack.flat_target)
    assert not torch.equal(first.stack.flat, learner_of(first.method).stack.flat)


def test_learning_draws_nothing_from_global_generators() -> None:
    before = torch.get_rng_state().clone(), repr(np.random.get_state(legacy=False))  # noqa: NPY002
    trained(small("hybrid-hrl"), steps=200)
    assert torch.equal(torch.get_rng_state(), before[0])
    assert repr(np.random.get_state(legacy=False)) == before[1]  # noqa: NPY002


@pytest.mark.parametrize(("name", "replay"), [("ddqn", "prioritised"), ("hybrid-hrl", "hierarchical")])
def test_a_gradient_step_is_adam_s_on_the_weighted_squared_errors(name: str, replay: Any) -> None:
    """Adam's first step is the learning rate times g / (|g| + epsilon), g the clipped gradient of each level's loss."""
    method = replace(small(name, warmup=100, max_gradient_norm=0.01), replay=replay)
    learner, twin = trained(method, steps=100)[0], trained(method, steps=100)[0]
    draw = twin._sampler.draw(twin._replay.stored)
    twin.stack.gradient.zero_()
    for level, part, weights in zip(
        twin.algorithm.td_errors(twin._replay.gather(draw.indices)), draw.parts, draw.weights, strict=True
    ):
        level.backward(part, torch.from_numpy(weights))
    before, gradient = learner.stack.flat.clone(), twin.stack.gradient
    for name_of_level in twin.algorithm.levels:
        part = twin.stack.part(f"{name_of_level}.")
        norms = gradient[:, part].norm(dim=1, keepdim=True)
        assert (norms > 0.01).all()
        gradient[:, part] *= 0.01 / norms
    learner._update(0.1)
    expected = before - 0.1 * gradient / (gradient.abs() + 1e-8)
    np.testing.assert_allclose(learner.stack.flat, expected, rtol=1e-3, atol=2e-3)
    assert (learner.stack.flat != before).any()


@pytest.mark.parametrize(("interval", "rate"), [(1, 1.0), (10, 1.0), (1, 0.1), (4, 0.5)])
def test_the_target_follows_at_its_interval_and_rate(interval: int, rate: float) -> None:
    learner, _ = trained(small("ddqn", warmup=40, target_interval=interval, target_rate=rate), steps=40)
    assert learner.updates == 0
    target = learner.stack.flat.clone()
    for update in range(1, 13):
        learner._update(0.01)
        if update % interval == 0:
            target += rate * (learner.stack.flat - target)
        np.testing.assert_allclose(learner.stack.flat_target, target, rtol=1e-5, atol=1e-6)
    if (interval, rate) == (1, 1.0):
        assert torch.equal(learner.stack.flat_target, learner.stack.flat)


def test_several_steps_are_joined_as_they_were_played() -> None:
    """The stored multi-step transitions are those of the same worlds replayed, also where the time limit cuts."""
    n_steps, steps, scenario = 3, 60, replace(MAIN, id="short", horizon=7, feasible_only=False)
    method = small("ddqn", n_steps=n_steps, warmup=1_000)
    learner = learner_of(method, (3,), scenario)
    list(learner.train(steps * N_ENVS))
    count = (steps - n_steps + 1) * N_ENVS
    assert (learner._replay.stored == count).all()
    batch, replayed, gamma = stored(learner, count), Simulator(scenario, N_ENVS), method.config.gamma
    replayed.reset(np.arange(N_ENVS) + 3 * N_ENVS)
    actions = batch.actions[0, 0].numpy().reshape(-1, N_ENVS)
    rewards, states, outcomes = [], [], []
    for now in range(len(actions)):
        replayed.step(actions[now])
        rewards.append(replayed.rewards - replayed.terms[:, TIMEOUT])
        states.append(replayed.observations.copy())
        outcomes.append(replayed.outcomes.copy())
        replayed.reset_done()
    assert (np.array(outcomes) == Outcome.TIMEOUT).any()
    for begin in range(len(actions) - n_steps + 1):
        for env in range(N_ENVS):
            total, discount = 0.0, 1.0
            for now in range(begin, begin + n_steps):
                total += discount * rewards[now][env] * method.config.reward_scale
                discount *= gamma if outcomes[now][env] in {Outcome.RUNNING, Outcome.TIMEOUT} else 0.0
                if outcomes[now][env] != Outcome.RUNNING:
                    break
            k = begin * N_ENVS + env
            assert batch.action_rewards[0, 0, k].item() == pytest.approx(total, rel=1e-5, abs=1e-6)
            assert batch.discounts[0, 0, k].item() == pytest.approx(discount, rel=1e-6)
            np.testing.assert_array_equal(batch.next_observations[0, :, k], states[now][env])


@pytest.mark.parametrize(
    "reading", [{"timeout": "terminal"}, {"priority": "shift"}, {"attended": "linear"}, {"credit": "algorithm-2"}]
)
def test_every_literal_reading_learns_something_else(reading: dict[str, Any]) -> None:
    scenario = replace(MAIN, id="short", horizon=90)
    learners = [learner_of(small("hybrid-hrl", **values), scenario=scenario) for values in ({}, reading)]
    for learner in learners:
        list(learner.train(800))
        assert learner.stack.flat.isfinite().all()
    assert not torch.equal(learners[0].stack.flat, learners[1].stack.flat)


@pytest.mark.parametrize("name", ["ddqn", "hybrid-hrl"])
@pytest.mark.parametrize("config", [{}, {"layer_norm": True, "attended": "linear"}])
def test_policies_act_as_their_seed_does_in_the_stack(name: str, config: dict[str, Any]) -> None:
    learner, _ = trained(small(name, **config))
    observations = np.random.default_rng(0).normal(size=(2, 200, SIZE)).astype(np.float32)
    greedy = [np.full((2, 200), GREEDY)] * len(learner.algorithm.levels)
    options, actions = learner.algorithm.choose(observations, greedy)
    for e, policy in enumerate(learner.policies()):
        decided = policy.act(observations[e])
        assert (decided.option == options[e]).mean() > 0.99
        assert (decided.action == actions[e]).mean() > 0.98
        for parameter, value in policy.parameters.items():
            assert np.array_equal(value[0], learner.stack.online[parameter][e])


@pytest.mark.parametrize("name", ["ddqn-plus", "hybrid-hrl-plus"])
def test_policies_remember_what_their_learner_does(name: str) -> None:
    learner, rows = trained(small(name))[0], 50
    simulator, memory = (
        Simulator(replace(MAIN, id="short", horizon=30, feasible_only=False), rows),
        Traces(learner.method.config.memory),
    )
    greedy = [np.full((2, rows), GREEDY)] * len(learner.algorithm.levels)
    for e, policy in enumerate(learner.policies()):
        simulator.reset(np.arange(rows))
        begins, agreed = np.ones(rows, np.bool_), list[float]()
        for _ in range(40):
            policy.reset(begins)
            memory.begin(begins)
            features = memory.observe(simulator.observations.copy())
            options, actions = learner.algorithm.choose(np.stack((features, features)), greedy)
            decided = policy.act(simulator.observations)
            agreed.append(((decided.option == options[e]) & (decided.action == actions[e])).mean())
            simulator.step(decided.action)
            begins = simulator.outcomes != Outcome.RUNNING
            simulator.reset_done()
        assert np.mean(agreed) > 0.98


def test_progress_counts_every_episode_and_every_step() -> None:
    learner, reports = trained(small("ddqn"), steps=2_000)
    assert [report.env_steps for report in reports] == list(range(100, 2_001, 100))
    assert reports[-1].updates == learner.updates == (2_000 - 40) // 4
    ended = (stored(learner, 2_000).discounts[:, 0] == 0).sum(-1).numpy()
    counted = sum(report.outcome_counts for report in reports)
    assert isinstance(counted, np.ndarray)
    assert counted.shape == (2, len(Outcome))
    assert not counted[:, Outcome.RUNNING].any()
    np.testing.assert_array_equal(counted.sum(axis=1) - counted[:, Outcome.TIMEOUT], ended)


def test_losses_are_reported_for_each_level_and_seed() -> None:
    _, reports = trained(small("hybrid-hrl"), steps=200)
    assert [list(report.losses) for report in reports] == [["option", "action"]] * 2
    for report in reports:
        for losses in report.losses.values():
            assert losses.shape == (2,)
            assert (losses > 0).all()


def test_without_a_gradient_step_there_is_no_loss() -> None:
    _, reports = trained(small("ddqn", warmup=400), steps=100)
    assert reports[0].updates == 0
    assert np.isnan(reports[0].losses["action"]).all()


def test_a_budget_is_rounded_up_to_whole_steps_and_reported() -> None:
    learner, reports = trained(small("ddqn"), steps=130)
    assert learner.env_steps == reports[-1].env_steps == 132
    assert [report.env_steps for report in reports] == [100, 132]


def test_policies_do_not_change_with_later_training() -> None:
    learner, _ = trained(small("hybrid-hrl"))
    before = learner.policies()
    kept = [{name: value.copy() for name, value in policy.parameters.items()} for policy in before]
    list(learner.train(600))
    for policy, parameters, after in zip(before, kept, learner.policies(), strict=True):
        assert all(np.array_equal(policy.parameters[name], value) for name, value in parameters.items())
        assert any(not np.array_equal(after.parameters[name], value) for name, value in parameters.items())


def test_policies_say_where_they_come_from() -> None:
    learner, _ = trained(small("hrl-2"), steps=100)
    for seed, policy in zip((3, 5), learner.policies(), strict=True):
        assert isinstance(policy, LearnedAgent)
        assert policy.metadata["seed"] == seed
        assert policy.metadata["env_steps"] == 100
        assert policy.metadata["method"] == "hrl-2"
        assert policy.metadata["config_hash"] == learner.method.config_hash
        assert policy.metadata["scenario"] == MAIN.id
        assert policy.metadata["interface_hash"] == MAIN.interface_hash


def test_worlds_must_be_one_for_each_environment() -> None:
    with pytest.raises(InputError, match=r"write \(1, 4\)"):
        DoubleDQNLearner(small("ddqn"), MAIN, [0], np.arange(5, dtype=np.uint64)[None])


def test_linear_goes_from_start_to_end_and_stays() -> None:
    assert [linear_schedule(1.0, 0.2, share) for share in (0.0, 0.5, 1.0, 3.0)] == pytest.approx([1.0, 0.6, 0.2, 0.2])


@pytest.mark.parametrize("name", ["ddqn", "hybrid-hrl"])
def test_learning_avoids_what_hurts_at_once(name: str) -> None:
    """After a short training the greedy policy changes its level far less abruptly than chance would."""
    method = small(name, n_envs=16, batch_size=64, hidden=(32, 32), warmup=200, target_interval=50)
    learner = learner_of(method, (1,))
    untrained = learner.policies()[0]
    list(learner.train(12_000))
    returns = [mean_return(agent) for agent in (untrained, learner.policies()[0])]
    assert returns[1] > returns[0] + 20.0


def mean_return(agent: LearnedAgent, rows: int = 100) -> float:
    simulator, total = Simulator(MAIN, rows), np.zeros(rows)
    simulator.reset(np.arange(rows) + 10_000)
    for _ in range(MAIN.horizon):
        simulator.step(agent.act(simulator.observations).action)
        total += simulator.rewards
    return float(total.mean())
