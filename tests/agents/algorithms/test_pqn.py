from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from hhrl_agents import METHODS
from hhrl_agents.algorithms import pqn
from hhrl_agents.algorithms.pqn import PQNLearner, RolloutStep, Targets, fit
from hhrl_agents.algorithms.td_errors import Settings
from hhrl_agents.methods.method import Method
from hhrl_agents.policies import checkpoints
from hhrl_agents.policies.learned_agent import LearnedAgent
from hhrl_agents.policies.observation_memory import Traces
from hhrl_agents.training.learner import Progress
from hhrl_envs import InputError, Outcome, Simulator, get_scenario
from hhrl_envs.arrays import Floats32, Ints
from hhrl_envs.observation import SIZE
from support import plain_networks

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


def learner_of(method: Method, seed: int = 5) -> PQNLearner:
    worlds = seed * method.config.n_envs + np.arange(method.config.n_envs)
    return PQNLearner(method, MAIN, seed, worlds.astype(np.uint64))


def trained(method: Method, seed: int = 5, steps: int = 640) -> tuple[PQNLearner, list[Progress]]:
    learner = learner_of(method, seed)
    return learner, list(learner.train(steps))


def leaves_of(learner: PQNLearner) -> plain_networks.Leaves:
    """The parameters of the network, float64."""
    return plain_networks.below(plain_networks.leaves(learner.parameters.snapshot()), "action.")


def plain_values(leaves: plain_networks.Leaves, states: Floats32) -> torch.Tensor:
    return plain_networks.mlp(leaves, torch.from_numpy(states).double(), layer_norm=True)


def test_steps_are_the_simulator_s_and_end_at_the_final_observation() -> None:
    learner = learner_of(small())
    steps = [learner._interact(1.0) for _ in range(200)]
    replayed = Simulator(MAIN, N_ENVS)
    replayed.reset(np.arange(N_ENVS) + learner.seed * N_ENVS)
    for step in steps:
        np.testing.assert_array_equal(step.observations, replayed.observations)
        replayed.step(step.actions)
        np.testing.assert_array_equal(step.next_observations, replayed.observations)
        np.testing.assert_array_equal(step.ended, replayed.outcomes != Outcome.RUNNING)
        replayed.reset_done()
    assert any(step.ended.any() for step in steps)


def test_memory_stands_beside_what_is_observed_and_begins_with_the_episode() -> None:
    learner = learner_of(small(memory=(0.5, 0.1)))
    steps, follows, begins = [learner._interact(1.0) for _ in range(200)], 0, 0
    states = learner._targets(steps).states.reshape(200, N_ENVS, 33)
    memory = Traces((0.5, 0.1))
    fresh = np.ones(N_ENVS, np.bool_)
    for at, step in enumerate(steps):
        memory.begin(fresh)
        features = memory.observe(step.observations[:, :SIZE], fresh)
        np.testing.assert_array_equal(step.observations, features)
        np.testing.assert_array_equal(states[at], features)
        following = memory.observe(step.next_observations[:, :SIZE])
        np.testing.assert_array_equal(step.next_observations, following)
        fresh = step.ended
        follows, begins = follows + int((~fresh).sum()), begins + int(fresh.sum())
    assert follows
    assert begins


@pytest.mark.parametrize("memory", [(), (0.5, 0.1)])
def test_a_rollout_s_targets_follow_the_recursion_of_q_lambda(memory: tuple[float, ...]) -> None:
    learner = learner_of(small(trace_decay=0.7, memory=memory))
    list(learner.train(320))
    steps = [learner._interact(1.0) for _ in range(200)]
    assert any(step.ended.any() for step in steps)
    targets, leaves = learner._targets(steps), leaves_of(learner)
    best = [plain_values(leaves, step.next_observations).amax(1).tolist() for step in steps]
    for env in range(N_ENVS):
        following = None
        for index in reversed(range(len(steps))):
            step, k, value = steps[index], index * N_ENVS + env, best[index][env]
            ahead = value if following is None or step.ended[env] else 0.3 * value + 0.7 * following
            following = step.rewards[env] + step.discounts[env] * ahead
            assert targets.returns[k] == pytest.approx(following, rel=1e-4, abs=1e-5)
            assert targets.actions[k] == step.actions[env]
            np.testing.assert_array_equal(targets.states[k], step.observations[env])


def test_time_limits_bootstrap_and_other_ends_do_not(monkeypatch: pytest.MonkeyPatch) -> None:
    learner = learner_of(small())
    standing = np.flatnonzero(np.array(MAIN.vehicle.levels) < 0)[0]
    monkeypatch.setattr(learner._explorers[0], "draw", lambda _: np.full(N_ENVS, standing))
    braked = [learner._interact(0.0) for _ in range(MAIN.horizon)]
    assert braked[-1].ended.any()
    assert (braked[-1].discounts == learner.method.config.gamma)[braked[-1].ended].all()
    assert (np.abs(braked[-1].rewards[braked[-1].ended]) < 1.0).all()
    fastest = int(np.argmax(MAIN.vehicle.levels))
    monkeypatch.setattr(learner._explorers[0], "draw", lambda _: np.full(N_ENVS, fastest))
    driven = [learner._interact(0.0) for _ in range(200)]
    ended = np.stack([step.ended for step in driven])
    assert ended.any()
    assert not np.stack([step.discounts for step in driven])[ended].any()


def test_every_epoch_uses_each_transition_once_in_an_order_of_each_seed(monkeypatch: pytest.MonkeyPatch) -> None:
    orders = []
    for seed in (3, 5):
        drawn = list[Ints]()
        monkeypatch.setattr(pqn, "fit", lambda *arguments, drawn=drawn: (drawn.append(arguments[3].copy()), 0.0)[1])
        list(learner_of(small(), seed).train(N_ENVS * ROLLOUT))
        assert [columns.size for columns in drawn] == [N_ENVS * ROLLOUT // 4] * 8
        orders += [np.concatenate(drawn[:4]), np.concatenate(drawn[4:])]
    assert all(np.array_equal(np.sort(order), np.arange(N_ENVS * ROLLOUT)) for order in orders)
    assert len({order.tobytes() for order in orders}) == len(orders)


def targets_of(learner: PQNLearner, count: int = 30) -> Targets:
    rng = np.random.default_rng(5)
    states = rng.normal(size=(count, learner.method.config.features)).astype(np.float32)
    return Targets(states, rng.integers(0, MAIN.num_actions, count), rng.normal(size=count).astype(np.float32))


@pytest.mark.parametrize("memory", [(), (0.5, 0.1)])
@pytest.mark.parametrize("count", [3, 8])
def test_a_gradient_step_descends_the_mean_squared_error(memory: tuple[float, ...], count: int) -> None:
    learner, _ = trained(small(memory=memory), steps=160)
    leaves, targets = leaves_of(learner), targets_of(learner)
    columns = np.random.default_rng(1).permutation(30)[:count]
    loss = mean_squared_error(leaves, targets, columns)
    expected = plain_networks.gradients(loss, leaves)
    found = fit(learner._memory, learner._level, targets, columns, learner._room, Settings(0.0, 1e-3, 1e9))
    assert found == pytest.approx(loss.item(), rel=1e-5)
    for name, gradient in learner.parameters._views(learner._memory.gradient).items():
        np.testing.assert_allclose(gradient[0], expected[name.removeprefix("action.")], rtol=1e-4, atol=1e-5)


def mean_squared_error(leaves: plain_networks.Leaves, targets: Targets, columns: Ints) -> torch.Tensor:
    values = plain_values(leaves, targets.states[columns])
    chosen = values[torch.arange(columns.size), torch.from_numpy(targets.actions[columns])]
    return (torch.from_numpy(targets.returns[columns]).double() - chosen).square().mean()


@pytest.mark.parametrize(("steps", "max_norm"), [(1, 0.1), (100, 5.0), (100, 0.1)])
def test_steps_are_those_of_adam(steps: int, max_norm: float) -> None:
    learner = learner_of(small())
    leaves, targets, rng = leaves_of(learner), targets_of(learner), np.random.default_rng(2)
    optimiser = torch.optim.Adam(leaves.values(), eps=1e-8)
    for step in range(steps):
        columns, rate = rng.permutation(30)[:8], 1e-3 / (1.0 + 0.1 * step)
        optimiser.zero_grad()
        mean_squared_error(leaves, targets, columns).backward()  # type: ignore[no-untyped-call]
        torch.nn.utils.clip_grad_norm_(leaves.values(), max_norm)
        optimiser.param_groups[0]["lr"] = rate
        optimiser.step()
        fit(learner._memory, learner._level, targets, columns, learner._room, Settings(0.0, rate, max_norm))
    for name, value in leaves_of(learner).items():
        np.testing.assert_allclose(value.detach(), leaves[name].detach(), rtol=1e-4, atol=2e-5)


def test_the_same_seed_learns_the_same_bits() -> None:
    first, second = trained(small())[0], trained(small())[0]
    np.testing.assert_array_equal(first.parameters.online, second.parameters.online)
    assert not np.array_equal(first.parameters.online, learner_of(small()).parameters.online)


def test_a_seed_learns_the_same_alone_and_beside_others() -> None:
    with ThreadPoolExecutor(3) as pool:
        beside = list(pool.map(lambda seed: trained(small(), seed, 256)[0], (3, 5, 8)))
    alone, _ = trained(small(), 5, 256)
    assert beside[1].runs_in_threads
    assert beside[1].updates == alone.updates == 64
    np.testing.assert_array_equal(beside[1].parameters.online, alone.parameters.online)
    assert not np.array_equal(beside[1].parameters.online, beside[0].parameters.online)


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
        assert report.losses["action"] > 0
        assert report.outcome_counts.shape == (len(Outcome),)


def test_progress_counts_every_episode_once(monkeypatch: pytest.MonkeyPatch) -> None:
    learner, ended = learner_of(small()), np.zeros(1, np.int64)
    interact = learner._interact

    def counted(epsilon: float) -> RolloutStep:
        step = interact(epsilon)
        ended[:] += step.ended.sum()
        return step

    monkeypatch.setattr(learner, "_interact", counted)
    counts = sum(report.outcome_counts for report in learner.train(2_000))
    assert isinstance(counts, np.ndarray)
    assert counts.sum() == ended > 0


@pytest.mark.parametrize("memory", [(), (0.5, 0.1)])
def test_policies_are_flat_agents_that_survive_a_checkpoint(tmp_path: Path, memory: tuple[float, ...]) -> None:
    learner, _ = trained(small(memory=memory))
    policy, path = learner.policy(), tmp_path / "5.safetensors"
    simulator = Simulator(MAIN, 50)
    simulator.reset(np.arange(50))
    checkpoints.save(path, policy)
    again = checkpoints.load(path)
    assert type(again) is LearnedAgent
    assert again.method == learner.method
    assert again.metadata["seed"] == 5
    assert again.metadata["env_steps"] == 640
    np.testing.assert_array_equal(again.act(simulator.observations), policy.act(simulator.observations))
    before = {name: value.copy() for name, value in policy.parameters.items()}
    list(learner.train(740))
    assert all(np.array_equal(policy.parameters[name], value) for name, value in before.items())
    assert any(not np.array_equal(value, before[name]) for name, value in learner.policy().parameters.items())


def test_worlds_must_be_one_for_each_environment() -> None:
    with pytest.raises(InputError, match=r"write \(4,\)"):
        PQNLearner(small(), MAIN, 0, np.arange(5, dtype=np.uint64))


def test_learning_raises_the_return() -> None:
    learner = learner_of(small(n_envs=16, hidden=(32, 32), rollout_steps=16), 1)
    untrained = learner.policy()
    list(learner.train(20_000))
    returns = [mean_return(agent) for agent in (untrained, learner.policy())]
    assert returns[1] > returns[0] + 20.0


def mean_return(agent: LearnedAgent, rows: int = 100) -> float:
    simulator, total = Simulator(MAIN, rows), np.zeros(rows)
    simulator.reset(np.arange(rows) + 10_000)
    for _ in range(MAIN.horizon):
        simulator.step(agent.act(simulator.observations).action)
        total += simulator.rewards
    return float(total.mean())
