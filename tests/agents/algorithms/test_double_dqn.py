from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from hhrl_agents import METHODS
from hhrl_agents.agent import ACTION
from hhrl_agents.algorithms.double_dqn import DoubleDQNLearner
from hhrl_agents.methods.configs import linear_schedule
from hhrl_agents.methods.method import Method
from hhrl_agents.policies.learned_agent import LearnedAgent, given_options
from hhrl_agents.policies.observation_memory import Traces
from hhrl_agents.replay.buffer import Transitions
from hhrl_agents.training.environments import learning_rewards
from hhrl_agents.training.learner import Progress
from hhrl_envs import InputError, Outcome, Scenario, Simulator, get_scenario
from hhrl_envs.arrays import Floats32, Ints
from hhrl_envs.observation import SIZE
from hhrl_envs.simulation.rewards import TIMEOUT, UNSMOOTH
from support import plain_learning, plain_networks

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


def learner_of(method: Method, seed: int = 5, scenario: Scenario = MAIN) -> DoubleDQNLearner:
    worlds = seed * method.config.n_envs + np.arange(method.config.n_envs)
    return DoubleDQNLearner(method, scenario, seed, worlds.astype(np.uint64))


def trained(method: Method, seed: int = 5, steps: int = 400) -> tuple[DoubleDQNLearner, list[Progress]]:
    learner = learner_of(method, seed)
    return learner, list(learner.train(steps))


def stored(learner: DoubleDQNLearner, count: int) -> Transitions:
    """The first `count` transitions."""
    return plain_learning.transitions(learner._replay.rows[:count])


def joined_steps(learner: DoubleDQNLearner, steps: int) -> int:
    """How many multi-step transitions every environment has after so many steps."""
    return steps - int(learner.method.config.n_steps) + 1


@pytest.mark.parametrize("name", NAMES)
def test_transitions_follow_each_other(name: str) -> None:
    steps, n_steps = 160, METHODS[name].config.n_steps
    learner, _ = trained(small(name, final_epsilon=1.0), steps=steps * N_ENVS)
    count = joined_steps(learner, steps)
    assert learner._replay.stored == count * N_ENVS
    batch, shape = stored(learner, count * N_ENVS), (count, N_ENVS, learner.method.config.features)
    first, second = batch.observations.reshape(shape), batch.next_observations.reshape(shape)
    goes_on = batch.discounts.reshape(shape[:2])[:-n_steps] > 0
    follows = (second[:-n_steps] == first[n_steps:]).all(-1)
    assert follows[goes_on].mean() > 0.99
    assert not follows[~goes_on].any()
    assert (first != second).any(-1).mean() > 0.9


class Played(NamedTuple):
    """What one step of every environment has been, by replaying its world."""

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


def replayed(learner: DoubleDQNLearner, batch: Transitions) -> list[Played]:
    """Every step of a seed's worlds, driven as the stored transitions say."""
    method, played = learner.method, list[Played]()
    simulator, memory = Simulator(learner.scenario, N_ENVS), Traces(method.config.memory)
    simulator.reset(np.arange(N_ENVS) + learner.seed * N_ENVS)
    goes_on = {Outcome.RUNNING, Outcome.TIMEOUT} if method.config.timeout == "truncation" else {Outcome.RUNNING}
    features = memory.observe(simulator.observations.copy())
    for step in range(len(batch.actions) // N_ENVS):
        rows = slice(step * N_ENVS, (step + 1) * N_ENVS)
        simulator.step(batch.actions[rows])
        rewards = level_rewards_of(method, simulator, batch.options[rows])
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
    played = replayed(learner, batch)
    assert np.stack([step.ended for step in played]).any()
    for begin, env in np.ndindex(count - n_steps + 1, N_ENVS):
        k, total, discount = begin * N_ENVS + env, np.zeros(2), np.ones(())
        for step in played[begin : begin + n_steps]:
            total, discount = total + discount * step.rewards[env], discount * step.discounts[env]
            if step.ended[env]:
                break
        assert batch.rewards[k] == pytest.approx(total, rel=1e-5, abs=1e-6)
        assert batch.discounts[k] == pytest.approx(discount, rel=1e-6)
        np.testing.assert_array_equal(batch.observations[k], played[begin].features[env])
        np.testing.assert_array_equal(batch.next_observations[k], step.next_features[env])


@pytest.mark.parametrize(
    ("name", "replay"),
    [("ddqn", "uniform"), ("ddqn", "prioritised"), ("hrl-0", "prioritised"), ("hybrid-hrl", "hierarchical")],
)
def test_a_seed_learns_the_same_alone_and_beside_others(name: str, replay: Any) -> None:
    method = replace(small(name, warmup=200), replay=replay)
    with ThreadPoolExecutor(3) as pool:
        beside = list(pool.map(lambda seed: trained(method, seed, steps=600)[0], (3, 5, 8)))
    alone, _ = trained(method, 5, steps=600)
    assert alone.runs_in_threads
    assert beside[1].updates == alone.updates == 100
    np.testing.assert_array_equal(beside[1]._replay.rows, alone._replay.rows)
    np.testing.assert_array_equal(beside[1].parameters.online, alone.parameters.online)
    assert not np.array_equal(beside[1].parameters.online, beside[0].parameters.online)


@pytest.mark.parametrize("name", NAMES)
def test_the_same_seed_learns_the_same_bits(name: str) -> None:
    first, second = trained(small(name))[0], trained(small(name))[0]
    np.testing.assert_array_equal(first.parameters.online, second.parameters.online)
    np.testing.assert_array_equal(first.parameters.target, second.parameters.target)
    np.testing.assert_array_equal(first._replay.rows, second._replay.rows)
    assert not np.array_equal(first.parameters.online, learner_of(first.method).parameters.online)


def test_learning_draws_nothing_from_global_generators() -> None:
    before = torch.get_rng_state().clone(), repr(np.random.get_state(legacy=False))  # noqa: NPY002
    trained(small("hybrid-hrl"), steps=200)
    assert torch.equal(torch.get_rng_state(), before[0])
    assert repr(np.random.get_state(legacy=False)) == before[1]  # noqa: NPY002


@pytest.mark.parametrize(
    ("name", "replay"),
    [
        ("ddqn", "uniform"),
        ("ddqn", "prioritised"),
        ("hybrid-hrl", "prioritised"),
        ("hybrid-hrl", "hierarchical"),
        ("hybrid-hrl-plus", "hierarchical"),
        ("rule-option", "prioritised"),
        ("option-only", "uniform"),
    ],
)
def test_a_gradient_step_is_adam_s_on_the_weighted_squared_errors(name: str, replay: Any) -> None:
    """Adam's first step is the learning rate times g / (|g| + epsilon), g the clipped gradient of each level's loss."""
    method = replace(small(name, warmup=100, max_gradient_norm=0.01), replay=replay)
    learner, twin = trained(method, steps=100)[0], trained(method, steps=100)[0]
    assert learner.updates == 0
    draw = twin._sampler.draw(twin._replay.stored)
    step, given = plain_learning.transitions(twin._replay.rows[draw.indices]), np.zeros(len(draw.indices), np.int64)
    if method.option.startswith("rule"):
        given = given_options(method, MAIN)(step.next_observations)
    online, target = (
        plain_networks.leaves(named(twin, flat)) for flat in (twin.parameters.online, twin._memory.target)
    )
    errors = plain_learning.td_errors(method, MAIN, online, target, step, given)
    before = learner.parameters.snapshot()
    learner._update(0.1)
    for level, first, weights, found in zip(
        learner.levels, draw.firsts, draw.weights, learner._found.errors, strict=True
    ):
        own = slice(first, first + weights.size)
        np.testing.assert_allclose(found[own], errors[level].detach()[own], rtol=1e-4, atol=1e-5)
        leaves = {key: value for key, value in online.items() if key.startswith(f"{level}.")}
        part = errors[level][own]
        gradients = plain_networks.gradients((torch.from_numpy(weights).double() * part.square()).mean(), leaves)
        norm = torch.cat([gradient.flatten() for gradient in gradients.values()]).norm()
        assert norm > 0.01
        for key, gradient in gradients.items():
            clipped = gradient * 0.01 / norm
            expected = torch.from_numpy(before[key][0]) - 0.1 * clipped / (clipped.abs() + 1e-8)
            np.testing.assert_allclose(learner.parameters.snapshot()[key][0], expected, rtol=1e-3, atol=2e-3)
            assert not np.array_equal(learner.parameters.snapshot()[key], before[key])


def named(learner: DoubleDQNLearner, flat: Floats32) -> dict[str, Floats32]:
    return learner.parameters._views(flat)


@pytest.mark.parametrize(("interval", "rate"), [(1, 1.0), (10, 1.0), (1, 0.1), (4, 0.5)])
def test_the_target_follows_at_its_interval_and_rate(interval: int, rate: float) -> None:
    learner, _ = trained(small("ddqn", warmup=40, target_interval=interval, target_rate=rate), steps=40)
    assert learner.updates == 0
    parameters = learner.parameters
    target = parameters.online.copy()
    for update in range(1, 13):
        learner._update(0.01)
        if update % interval == 0:
            target += np.float32(rate) * (parameters.online - target)
        np.testing.assert_allclose(parameters.target, target, rtol=1e-5, atol=1e-6)
    assert np.array_equal(parameters.target, parameters.online) == ((interval, rate) == (1, 1.0))


def test_several_steps_are_joined_as_they_were_played() -> None:
    """The stored multi-step transitions are those of the same worlds replayed, also where the time limit cuts."""
    n_steps, steps, scenario = 3, 60, replace(MAIN, id="short", horizon=7, feasible_only=False)
    method = small("ddqn", n_steps=n_steps, warmup=1_000)
    learner = learner_of(method, 3, scenario)
    list(learner.train(steps * N_ENVS))
    count = (steps - n_steps + 1) * N_ENVS
    assert learner._replay.stored == count
    batch, replayed, gamma = stored(learner, count), Simulator(scenario, N_ENVS), method.config.gamma
    replayed.reset(np.arange(N_ENVS) + 3 * N_ENVS)
    actions = batch.actions.reshape(-1, N_ENVS)
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
            assert batch.rewards[k, ACTION] == pytest.approx(total, rel=1e-5, abs=1e-6)
            assert batch.discounts[k] == pytest.approx(discount, rel=1e-6)
            np.testing.assert_array_equal(batch.next_observations[k], states[now][env])


@pytest.mark.parametrize(
    "reading", [{"timeout": "terminal"}, {"priority": "shift"}, {"attended": "linear"}, {"credit": "algorithm-2"}]
)
def test_every_literal_reading_learns_something_else(reading: dict[str, Any]) -> None:
    scenario = replace(MAIN, id="short", horizon=90)
    learners = [learner_of(small("hybrid-hrl", **values), scenario=scenario) for values in ({}, reading)]
    for learner in learners:
        list(learner.train(800))
        assert np.isfinite(learner.parameters.online).all()
    assert not np.array_equal(learners[0].parameters.online, learners[1].parameters.online)


def choices(learner: DoubleDQNLearner, features: Floats32) -> tuple[Ints, Ints]:
    """What the learner chooses where nothing is tried."""
    learner._environments.features = features
    return learner._choose({})


@pytest.mark.parametrize("name", ["ddqn", "hybrid-hrl", "rule-option", "option-only"])
@pytest.mark.parametrize("config", [{}, {"layer_norm": True, "attended": "linear"}])
def test_policies_act_as_their_learner_does(name: str, config: dict[str, Any]) -> None:
    learner, _ = trained(small(name, **config))
    observations = np.random.default_rng(0).normal(size=(200, SIZE)).astype(np.float32)
    policy = learner.policy()
    decided, (options, actions) = policy.act(observations), choices(learner, observations)
    np.testing.assert_array_equal(decided.option, options)
    np.testing.assert_array_equal(decided.action, actions)
    for parameter, value in learner.parameters.snapshot().items():
        np.testing.assert_array_equal(policy.parameters[parameter], value)


@pytest.mark.parametrize("name", ["ddqn-plus", "hybrid-hrl-plus"])
def test_policies_remember_what_their_learner_does(name: str) -> None:
    learner, rows = trained(small(name))[0], 50
    simulator, memory = (
        Simulator(replace(MAIN, id="short", horizon=30, feasible_only=False), rows),
        Traces(learner.method.config.memory),
    )
    policy = learner.policy()
    simulator.reset(np.arange(rows))
    begins = np.ones(rows, np.bool_)
    for _ in range(40):
        policy.reset(begins)
        memory.begin(begins)
        options, actions = choices(learner, memory.observe(simulator.observations.copy()))
        decided = policy.act(simulator.observations)
        np.testing.assert_array_equal(decided.option, options)
        np.testing.assert_array_equal(decided.action, actions)
        simulator.step(decided.action)
        begins = simulator.outcomes != Outcome.RUNNING
        simulator.reset_done()


def test_progress_counts_every_episode_and_every_step() -> None:
    learner, reports = trained(small("ddqn"), steps=2_000)
    assert [report.env_steps for report in reports] == list(range(100, 2_001, 100))
    assert reports[-1].updates == learner.updates == (2_000 - 40) // 4
    ended = (stored(learner, 2_000).discounts == 0).sum()
    counted = sum(report.outcome_counts for report in reports)
    assert isinstance(counted, np.ndarray)
    assert counted.shape == (len(Outcome),)
    assert not counted[Outcome.RUNNING]
    assert counted.sum() - counted[Outcome.TIMEOUT] == ended > 0


def test_losses_are_reported_for_each_level() -> None:
    _, reports = trained(small("hybrid-hrl"), steps=200)
    assert [list(report.losses) for report in reports] == [["option", "action"]] * 2
    for report in reports:
        assert all(loss > 0 for loss in report.losses.values())


def test_without_a_gradient_step_there_is_no_loss() -> None:
    _, reports = trained(small("ddqn", warmup=400), steps=100)
    assert reports[0].updates == 0
    assert np.isnan(reports[0].losses["action"])


def test_a_budget_is_rounded_up_to_whole_steps_and_reported() -> None:
    learner, reports = trained(small("ddqn"), steps=130)
    assert learner.env_steps == reports[-1].env_steps == 132
    assert [report.env_steps for report in reports] == [100, 132]


def test_policies_do_not_change_with_later_training() -> None:
    learner, _ = trained(small("hybrid-hrl"))
    policy = learner.policy()
    kept = {name: value.copy() for name, value in policy.parameters.items()}
    list(learner.train(600))
    after = learner.policy()
    assert all(np.array_equal(policy.parameters[name], value) for name, value in kept.items())
    assert any(not np.array_equal(after.parameters[name], value) for name, value in kept.items())


def test_policies_say_where_they_come_from() -> None:
    learner, _ = trained(small("hrl-2"), steps=100)
    policy = learner.policy()
    assert isinstance(policy, LearnedAgent)
    assert policy.metadata["seed"] == 5
    assert policy.metadata["env_steps"] == 100
    assert policy.metadata["method"] == "hrl-2"
    assert policy.metadata["config_hash"] == learner.method.config_hash
    assert policy.metadata["scenario"] == MAIN.id
    assert policy.metadata["interface_hash"] == MAIN.interface_hash


def test_worlds_must_be_one_for_each_environment() -> None:
    with pytest.raises(InputError, match=r"write \(4,\)"):
        DoubleDQNLearner(small("ddqn"), MAIN, 0, np.arange(5, dtype=np.uint64))


def test_linear_goes_from_start_to_end_and_stays() -> None:
    assert [linear_schedule(1.0, 0.2, share) for share in (0.0, 0.5, 1.0, 3.0)] == pytest.approx([1.0, 0.6, 0.2, 0.2])


@pytest.mark.parametrize(("name", "steps"), [("ddqn", 24_000), ("hybrid-hrl", 48_000)])
def test_learning_raises_the_return(name: str, steps: int) -> None:
    """The median of three seeds: after so short a training, one in some is still worse than chance."""
    method = small(name, n_envs=16, batch_size=64, hidden=(32, 32), warmup=200, target_interval=50)

    def returns(seed: int) -> tuple[float, float]:
        learner = learner_of(method, seed)
        untrained = learner.policy()
        list(learner.train(steps))
        return mean_return(untrained), mean_return(learner.policy())

    with ThreadPoolExecutor(3) as pool:
        before, after = np.median(list(pool.map(returns, (1, 2, 3))), axis=0)
    assert after > before + 20.0


def mean_return(agent: LearnedAgent, rows: int = 100) -> float:
    simulator, total = Simulator(MAIN, rows), np.zeros(rows)
    simulator.reset(np.arange(rows) + 10_000)
    for _ in range(MAIN.horizon):
        simulator.step(agent.act(simulator.observations).action)
        total += simulator.rewards
    return float(total.mean())
