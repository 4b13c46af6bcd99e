from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from hhrl_agents import METHODS
from hhrl_agents.algorithms.pqn import PQNLearner, RolloutStep, Targets
from hhrl_agents.methods.method import Method
from hhrl_agents.policies import checkpoints
from hhrl_agents.policies.learned_agent import LearnedAgent
from hhrl_agents.policies.observation_memory import Traces
from hhrl_agents.training.learner import Progress
from hhrl_envs import InputError, Outcome, Simulator, get_scenario
from hhrl_envs.observation import SIZE

MAIN = get_scenario("stop-line-v0")
N_ENVS = 4
ROLLOUT = 8
SMALL: dict[str, Any] = {
    "hidden": (16, 16),
    "n_envs": N_ENVS,
    "rollout_steps": ROLLOUT,
    "epochs": 2,
    "minibatches": 4,
    "report_every": 100,
}


def small(**values: Any) -> Method:
    method = METHODS["pqn"]
    return replace(method, config=replace(method.config, **{**SMALL, **values}))


def learner_of(method: Method, seeds: Sequence[int] = (3, 5)) -> PQNLearner:
    worlds = np.array(seeds)[:, None] * method.config.n_envs + np.arange(method.config.n_envs)
    return PQNLearner(method, MAIN, seeds, worlds.astype(np.uint64))


def trained(method: Method, seeds: Sequence[int] = (3, 5), steps: int = 640) -> tuple[PQNLearner, list[Progress]]:
    learner = learner_of(method, seeds)
    return learner, list(learner.train(steps))


def best_value(learner: PQNLearner, seed: int, observation: np.ndarray[Any, Any]) -> float:
    """The highest action value by plain layers."""
    parameters = {name: value[seed] for name, value in learner.stack.online.items()}
    outputs = torch.from_numpy(observation.copy())
    depth = len(parameters) // 2
    for layer in range(depth):
        outputs = outputs @ parameters[f"action.{layer}.weight"] + parameters[f"action.{layer}.bias"][0]
        if layer < depth - 1:
            outputs = torch.nn.functional.layer_norm(outputs, outputs.shape).relu()
    return float(outputs.max())


def test_steps_are_the_simulator_s_and_end_at_the_final_observation() -> None:
    learner = learner_of(small())
    steps = [learner._interact(1.0) for _ in range(200)]
    for index, seed in enumerate(learner.seeds):
        replayed = Simulator(MAIN, N_ENVS)
        replayed.reset(np.arange(N_ENVS) + seed * N_ENVS)
        for step in steps:
            np.testing.assert_array_equal(step.observations[index], replayed.observations)
            replayed.step(step.actions[index])
            np.testing.assert_array_equal(step.next_observations[index], replayed.observations)
            np.testing.assert_array_equal(step.ended[index], replayed.outcomes != Outcome.RUNNING)
            replayed.reset_done()
    assert any(step.ended.any() for step in steps)


def test_memory_stands_beside_what_is_observed_and_begins_with_the_episode() -> None:
    learner = learner_of(small(memory=(0.5, 0.1)))
    steps, follows, begins = [learner._interact(1.0) for _ in range(200)], 0, 0
    states = learner._targets(steps).states.reshape(2, 33, 200, N_ENVS)
    for index in range(2):
        memory = Traces((0.5, 0.1))
        fresh = np.ones(N_ENVS, np.bool_)
        for at, step in enumerate(steps):
            memory.begin(fresh)
            features = memory.observe(step.observations[index, :, :SIZE], fresh)
            np.testing.assert_array_equal(step.observations[index], features)
            np.testing.assert_array_equal(states[index, :, at].T, features)
            following = memory.observe(step.next_observations[index, :, :SIZE])
            np.testing.assert_array_equal(step.next_observations[index], following)
            fresh = step.ended[index]
            follows, begins = follows + int((~fresh).sum()), begins + int(fresh.sum())
    assert follows
    assert begins


@pytest.mark.parametrize("memory", [(), (0.5, 0.1)])
def test_a_rollout_s_targets_follow_the_recursion_of_q_lambda(memory: tuple[float, ...]) -> None:
    learner = learner_of(small(trace_decay=0.7, memory=memory))
    list(learner.train(320))
    steps = [learner._interact(1.0) for _ in range(200)]
    assert any(step.ended.any() for step in steps)
    targets = learner._targets(steps)
    for seed in range(2):
        for env in range(N_ENVS):
            following = None
            for index in reversed(range(len(steps))):
                step, column = steps[index], index * N_ENVS + env
                value = best_value(learner, seed, step.next_observations[seed, env])
                ahead = value if following is None or step.ended[seed, env] else 0.3 * value + 0.7 * following
                following = step.rewards[seed, env] + step.discounts[seed, env] * ahead
                assert targets.returns[seed, 0, column].item() == pytest.approx(following, rel=1e-3, abs=1e-4)
                assert targets.actions[seed, 0, column] == step.actions[seed, env]
                np.testing.assert_array_equal(targets.states[seed, :, column], step.observations[seed, env])


def test_time_limits_bootstrap_and_other_ends_do_not(monkeypatch: pytest.MonkeyPatch) -> None:
    learner = learner_of(small())
    standing = np.flatnonzero(np.array(MAIN.vehicle.levels) < 0)[0]
    monkeypatch.setattr(learner._explorers[0], "draw", lambda _: np.full((2, N_ENVS), standing))
    braked = [learner._interact(0.0) for _ in range(MAIN.horizon)]
    assert braked[-1].ended.any()
    assert (braked[-1].discounts == learner.method.config.gamma)[braked[-1].ended].all()
    assert (np.abs(braked[-1].rewards[braked[-1].ended]) < 1.0).all()
    fastest = int(np.argmax(MAIN.vehicle.levels))
    monkeypatch.setattr(learner._explorers[0], "draw", lambda _: np.full((2, N_ENVS), fastest))
    driven = [learner._interact(0.0) for _ in range(200)]
    ended = np.stack([step.ended for step in driven])
    assert ended.any()
    assert not np.stack([step.discounts for step in driven])[ended].any()


def test_every_epoch_uses_each_transition_once_in_an_order_of_each_seed() -> None:
    learner = learner_of(small())
    first, second = (torch.cat(list(learner._shuffled()), dim=2)[:, 0] for _ in range(2))
    for orders in (first, second):
        assert torch.equal(orders.sort(1).values, torch.arange(N_ENVS * ROLLOUT).expand(2, -1))
        assert not torch.equal(orders[0], orders[1])
    assert not torch.equal(first, second)


def test_a_gradient_step_descends_the_mean_squared_error() -> None:
    learner, _ = trained(small(max_gradient_norm=1e9), steps=160)
    draw = torch.Generator().manual_seed(5)
    states = torch.randn(2, 11, 9, generator=draw)
    actions = torch.randint(0, MAIN.num_actions, (2, 1, 9), generator=draw)
    returns = torch.randn(2, 1, 9, generator=draw)
    leaf = learner.stack.flat.clone().requires_grad_()
    outputs, offset = states.transpose(1, 2), 0
    for layer, (fan_in, fan_out) in enumerate([(11, 16), (16, 16), (16, MAIN.num_actions)]):
        weight = leaf[:, offset : offset + fan_in * fan_out].view(2, fan_in, fan_out)
        offset += fan_in * fan_out
        outputs = outputs @ weight + leaf[:, None, offset : offset + fan_out]
        offset += fan_out
        if layer < 2:
            outputs = torch.nn.functional.layer_norm(outputs, (fan_out,)).relu()
    chosen = outputs.gather(2, actions.transpose(1, 2))
    (expected,) = torch.autograd.grad((returns.transpose(1, 2) - chosen).square().mean((1, 2)).sum(), leaf)
    learner._update(Targets(states, actions, returns), 1e-3)
    np.testing.assert_allclose(learner.stack.gradient, expected, rtol=1e-3, atol=1e-5)


def test_the_same_stack_learns_the_same_bits() -> None:
    first, second = trained(small())[0], trained(small())[0]
    assert torch.equal(first.stack.flat, second.stack.flat)


def test_a_seed_learns_the_same_alone_and_in_a_stack() -> None:
    together, alone = trained(small(), (3, 5, 8), 256)[0], trained(small(), (5,), 256)[0]
    assert together.updates == alone.updates == 64
    np.testing.assert_allclose(together.stack.flat[1], alone.stack.flat[0], rtol=1e-3, atol=2e-5)
    assert not torch.equal(together.stack.flat[1], together.stack.flat[0])


def test_learning_draws_nothing_from_global_generators() -> None:
    before = torch.get_rng_state().clone(), repr(np.random.get_state(legacy=False))  # noqa: NPY002
    trained(small(), steps=100)
    assert torch.equal(torch.get_rng_state(), before[0])
    assert repr(np.random.get_state(legacy=False)) == before[1]  # noqa: NPY002


def test_progress_counts_every_step_in_whole_rollouts() -> None:
    learner, reports = trained(small(), steps=650)
    size = N_ENVS * ROLLOUT
    assert learner.env_steps == reports[-1].env_steps == 21 * size
    assert [report.env_steps for report in reports] == [128, 224, 320, 416, 512, 608, 672]
    assert reports[-1].updates == learner.updates == 21 * 8
    for report in reports:
        assert report.losses["action"].shape == (2,)
        assert (report.losses["action"] > 0).all()
        assert report.outcome_counts.shape == (2, len(Outcome))


def test_progress_counts_every_episode_once(monkeypatch: pytest.MonkeyPatch) -> None:
    learner, ended = learner_of(small()), np.zeros(2, np.int64)
    interact = learner._interact

    def counted(epsilon: float) -> RolloutStep:
        step = interact(epsilon)
        ended[:] += step.ended.sum(1)
        return step

    monkeypatch.setattr(learner, "_interact", counted)
    counts = sum(report.outcome_counts for report in learner.train(2_000))
    assert isinstance(counts, np.ndarray)
    assert ended.all()
    np.testing.assert_array_equal(counts.sum(1), ended)


@pytest.mark.parametrize("memory", [(), (0.5, 0.1)])
def test_policies_are_flat_agents_that_survive_a_checkpoint(tmp_path: Path, memory: tuple[float, ...]) -> None:
    learner, _ = trained(small(memory=memory))
    policies = learner.policies()
    simulator = Simulator(MAIN, 50)
    simulator.reset(np.arange(50))
    for seed, policy in zip((3, 5), policies, strict=True):
        path = tmp_path / f"{seed}.safetensors"
        checkpoints.save(path, policy)
        again = checkpoints.load(path)
        assert type(again) is LearnedAgent
        assert again.method == learner.method
        assert again.metadata["seed"] == seed
        assert again.metadata["env_steps"] == 640
        np.testing.assert_array_equal(again.act(simulator.observations), policy.act(simulator.observations))
    before = {name: value.copy() for name, value in policies[0].parameters.items()}
    list(learner.train(100))
    assert all(np.array_equal(policies[0].parameters[name], value) for name, value in before.items())


def test_worlds_must_be_one_for_each_environment() -> None:
    with pytest.raises(InputError, match=r"write \(1, 4\)"):
        PQNLearner(small(), MAIN, [0], np.arange(5, dtype=np.uint64)[None])


def test_learning_raises_the_return() -> None:
    learner = learner_of(small(n_envs=16, hidden=(32, 32), rollout_steps=16), (1,))
    untrained = learner.policies()[0]
    list(learner.train(20_000))
    returns = [mean_return(agent) for agent in (untrained, learner.policies()[0])]
    assert returns[1] > returns[0] + 20.0


def mean_return(agent: LearnedAgent, rows: int = 100) -> float:
    simulator, total = Simulator(MAIN, rows), np.zeros(rows)
    simulator.reset(np.arange(rows) + 10_000)
    for _ in range(MAIN.horizon):
        simulator.step(agent.act(simulator.observations).action)
        total += simulator.rewards
    return float(total.mean())
