"""PPO by Stable-Baselines3 as a method: the same worlds, rewards and interface as every learner's."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from hhrl_agents import METHODS
from hhrl_agents.algorithms.ppo import PPOLearner
from hhrl_agents.methods.configs import PPOConfig
from hhrl_agents.methods.method import Method
from hhrl_agents.policies import checkpoints
from hhrl_agents.policies.learned_agent import LearnedAgent
from hhrl_agents.training.learner import Progress, make_learner
from hhrl_envs import InputError, Outcome, Scenario, Simulator, get_scenario
from hhrl_envs.observation import SIZE
from hhrl_envs.simulation.rewards import TIMEOUT, UNSMOOTH

MAIN = get_scenario("stop-line-v0")
SHORT = replace(MAIN, id="short", horizon=90)
N_ENVS = 4
SMALL = PPOConfig(hidden=(16, 16), n_envs=N_ENVS, rollout_steps=16, epochs=2, batch_size=32, report_every=100)


def small(**values: Any) -> Method:
    return replace(METHODS["ppo"], config=replace(SMALL, **values))


def learner_of(seed: int = 5, scenario: Scenario = MAIN, **values: Any) -> PPOLearner:
    worlds = seed * N_ENVS + np.arange(N_ENVS, dtype=np.uint64)
    learner = make_learner(small(**values), scenario, seed, worlds)
    assert isinstance(learner, PPOLearner)
    return learner


def trained(seed: int = 5, steps: int = 256, **values: Any) -> tuple[PPOLearner, list[Progress]]:
    learner = learner_of(seed, **values)
    return learner, list(learner.train(steps))


def same(first: LearnedAgent, second: LearnedAgent) -> bool:
    return all(np.array_equal(value, second.parameters[name]) for name, value in first.parameters.items())


def test_the_policy_is_what_the_library_predicts() -> None:
    learner, _ = trained(learning_rate=0.03)
    observations = 10 * np.random.default_rng(0).normal(size=(500, SIZE)).astype(np.float32)
    predicted, _ = learner._trained._ppo.predict(observations, deterministic=True)
    assert len(set(predicted)) > 1
    np.testing.assert_array_equal(learner.policy().act(observations).action, predicted)


def test_a_seed_learns_the_same_alone_and_after_others() -> None:
    torch.manual_seed(1)
    policies = [trained(seed)[0].policy() for seed in (3, 5, 8)]
    torch.manual_seed(2)
    assert same(policies[1], trained(5)[0].policy())
    assert not same(policies[0], policies[1])


def test_learners_that_take_turns_learn_the_same() -> None:
    learners = [learner_of(seed) for seed in (3, 5)]
    for _ in zip(*(learner.train(256) for learner in learners), strict=True):
        pass
    for seed, learner in zip((3, 5), learners, strict=True):
        assert same(learner.policy(), trained(seed)[0].policy())
        assert not learner.runs_in_threads


def test_learning_leaves_the_global_generators_as_they_were() -> None:
    before = torch.get_rng_state().clone(), repr(np.random.get_state(legacy=False))  # noqa: NPY002
    first = trained()[0].policy()
    assert torch.equal(torch.get_rng_state(), before[0])
    assert repr(np.random.get_state(legacy=False)) == before[1]  # noqa: NPY002
    torch.rand(3)
    np.random.random(3)  # noqa: NPY002
    assert same(first, trained()[0].policy())


def test_reports_come_after_rollouts_and_count_steps_and_updates() -> None:
    learner, reports = trained(steps=300)
    assert [report.env_steps for report in reports] == [128, 256, 300]
    assert [report.updates for report in reports] == [8, 16, 20]
    assert (learner.env_steps, learner.updates) == (300, 20)
    for report in reports:
        assert list(report.losses) == ["policy", "value"]
        assert np.isfinite([*report.losses.values()]).all()


@pytest.mark.parametrize(("budget", "taken"), [(1, 4), (8, 8), (50, 52), (66, 68)])
def test_a_short_budget_is_kept_to_whole_steps(budget: int, taken: int) -> None:
    learner, reports = trained(0, budget)
    assert learner.env_steps == reports[-1].env_steps == taken
    assert learner.policy().metadata["env_steps"] == taken


def test_training_goes_on_where_it_ended_and_policies_stay() -> None:
    learner, _ = trained()
    policy = learner.policy()
    kept = {name: value.copy() for name, value in policy.parameters.items()}
    assert [report.env_steps for report in learner.train(320)] == [320]
    assert all(np.array_equal(policy.parameters[name], value) for name, value in kept.items())
    assert not same(policy, learner.policy())


def test_every_episode_is_counted() -> None:
    learner = learner_of(scenario=SHORT)
    ended = sum(report.outcome_counts for report in learner.train(N_ENVS * SHORT.horizon))
    assert isinstance(ended, np.ndarray)
    assert ended.shape == (len(Outcome),)
    assert not ended[Outcome.RUNNING]
    assert ended.sum() >= N_ENVS


def test_a_checkpoint_comes_back_as_it_was(tmp_path: Path) -> None:
    policy = trained()[0].policy()
    checkpoints.save(tmp_path / "seed-5.safetensors", policy)
    loaded = checkpoints.load(tmp_path / "seed-5.safetensors")
    assert same(policy, loaded)
    assert loaded.method == policy.method
    assert loaded.metadata["seed"] == 5
    assert loaded.metadata["versions"].keys() == {"stable_baselines3", "torch"}


@pytest.mark.parametrize(("timeout", "weight"), [("truncation", 1.0), ("terminal", 1.0), ("truncation", 0.3)])
def test_rewards_are_the_simulator_s_and_a_time_limit_bootstraps(timeout: str, weight: float) -> None:
    still = {"learning_rate": 1e-30, "final_learning_rate": 1e-30}
    learner = learner_of(7, SHORT, timeout=timeout, jerk_weight=weight, rollout_steps=128, **still)
    list(learner.train(128 * N_ENVS))
    ppo, config = learner._trained._ppo, learner.method.config
    buffer, replayed = ppo.rollout_buffer, Simulator(SHORT, N_ENVS)
    replayed.reset(np.arange(N_ENVS) + 7 * N_ENVS)
    truncated = unsmooth = 0
    observed, acted = by_step(buffer.observations), by_step(buffer.actions)[..., 0].astype(np.int64)
    for step in range(128):
        np.testing.assert_array_equal(observed[step], replayed.observations)
        replayed.step(acted[step])
        expected, late = replayed.rewards.copy(), replayed.outcomes == Outcome.TIMEOUT
        with torch.no_grad():
            values = ppo.policy.predict_values(torch.from_numpy(replayed.observations.copy())).numpy()[:, 0]
        expected -= (1.0 - weight) * replayed.terms[:, UNSMOOTH]
        expected *= config.reward_scale
        if timeout == "truncation":
            expected[late] -= config.reward_scale * replayed.terms[late, TIMEOUT]
            expected[late] += config.gamma * values[late]
        np.testing.assert_allclose(buffer.rewards[step], expected, rtol=1e-5, atol=1e-6)
        truncated += int(late.sum())
        unsmooth += int((replayed.terms[:, UNSMOOTH] < 0.0).sum())
        replayed.reset_done()
    assert truncated
    assert unsmooth


def by_step(flat: Any) -> Any:
    """The rollout's transitions, which the library has put one environment after the other, as [steps, N_ENVS, ...]."""
    return flat.reshape(N_ENVS, -1, *flat.shape[1:]).swapaxes(0, 1)


def test_worlds_must_be_one_for_each_environment() -> None:
    with pytest.raises(InputError, match=r"write \(4,\)"):
        PPOLearner(small(), MAIN, 0, np.arange(5, dtype=np.uint64))


def test_without_the_library_one_line_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hhrl_envs.errors.find_spec", lambda _: None)
    with pytest.raises(InputError, match=r"pip install -e '.\[sb3\]'"):
        learner_of()


def test_torch_computes_with_one_thread_while_it_learns(monkeypatch: pytest.MonkeyPatch) -> None:
    learner, threads = learner_of(), []
    learn = learner._trained._ppo.learn

    def watched(*args: Any, **kwargs: Any) -> Any:
        threads.append(torch.get_num_threads())
        return learn(*args, **kwargs)

    monkeypatch.setattr(learner._trained._ppo, "learn", watched)
    before = torch.get_num_threads()
    torch.set_num_threads(2)
    list(learner.train(64))
    assert torch.get_num_threads() == 2
    torch.set_num_threads(before)
    assert threads == [1]
