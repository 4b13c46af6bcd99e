"""A learner's state: a fresh learner that takes it up goes on to the same bits."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from hhrl_agents import METHODS
from hhrl_agents.algorithms.double_dqn import DoubleDQNLearner
from hhrl_agents.methods.method import Method
from hhrl_agents.policies import checkpoints
from hhrl_agents.policies.checkpoint_file import SHIPPED
from hhrl_agents.training.drivers import EGO_ALONE, Drivers
from hhrl_agents.training.learner import Learner, make_learner
from hhrl_envs import InputError, get_scenario
from hhrl_envs.state import State
from support.configs import with_values

SMALL: dict[str, Any] = {
    "hidden": (16, 16),
    "n_envs": 4,
    "batch_size": 8,
    "replay_capacity": 600,  # so that the ring goes round
    "warmup": 40,
    "target_interval": 10,
    "report_every": 500,
    "rollout_steps": 5,
    "epochs": 2,
    "minibatches": 4,
}
BUDGET = 1_000


def small(name: str, **values: Any) -> Method:
    method = METHODS[name]
    changes = {key: values.pop(key) for key in ("replay",) if key in values}
    return replace(with_values(method, {**SMALL, **values}), **changes)


def drivers_of(scenario: str) -> Drivers:
    if scenario == "adversary-v0":  # behind it, an ego that remembers
        return Drivers((1,), {0: checkpoints.load(SHIPPED / "hybrid-hrl-plus" / "seed-0.safetensors")})
    return Drivers((0, 1, 2, 3)) if scenario == "platoon-v0" else EGO_ALONE


def made(method: Method, scenario: str = "stop-line-v0", seed: int = 3) -> Learner:
    worlds = np.arange(4, dtype=np.uint64) + 4 * seed
    return make_learner(method, get_scenario(scenario), seed, worlds, drivers=drivers_of(scenario))


def learner_of(method: Method, seed: int = 3) -> DoubleDQNLearner:
    learner = made(method, seed=seed)
    assert isinstance(learner, DoubleDQNLearner)
    return learner


def state_of(learner: Learner) -> State:
    state = learner.state()
    assert state is not None
    return state


def equal(first: State, second: State) -> None:
    assert first.keys() == second.keys()
    for name, array in first.items():
        assert array.dtype == second[name].dtype
        np.testing.assert_array_equal(array, second[name], err_msg=name)


@pytest.mark.parametrize(
    ("method", "scenario"),
    [
        (small("ddqn"), "stop-line-v0"),
        (small("hybrid-hrl"), "stop-line-noisy-v0"),
        (small("ddqn", n_steps=3), "stop-line-v0"),
        (small("ddqn", replay="prioritised", target_rate=0.1), "stop-line-v0"),
        (small("hybrid-hrl-plus"), "stop-line-noisy-v0"),
        (small("option-only"), "stop-line-v0"),
        (small("hybrid-hrl-plus"), "platoon-v0"),
        (small("ddqn-plus"), "adversary-v0"),
        (small("pqn"), "stop-line-v0"),
        (small("pqn", memory=(0.3, 0.05)), "stop-line-noisy-v0"),
    ],
    ids=[
        *("flat", "hierarchical", "multi-step", "prioritised", "plus", "given-actions"),
        *("shared", "against-an-ego", "pqn", "pqn-with-memory"),
    ],
)
def test_a_fresh_learner_goes_on_to_the_same_bits(method: Method, scenario: str) -> None:
    whole = made(method, scenario)
    reports = list(whole.train(BUDGET))
    stopped = made(method, scenario)
    first = next(training := stopped.train(BUDGET))
    saved = state_of(stopped)
    kept = {name: array.copy() for name, array in saved.items()}
    list(training)
    equal(saved, kept)
    fresh = made(method, scenario)
    fresh.restore(saved)
    (second,) = fresh.train(BUDGET)
    equal(state_of(whole), state_of(fresh))
    for report, same in zip(reports, (first, second), strict=True):
        assert (report.env_steps, report.updates) == (same.env_steps, same.updates)
        np.testing.assert_array_equal(report.outcome_counts, same.outcome_counts)
        np.testing.assert_array_equal(list(report.losses.values()), list(same.losses.values()))


def test_the_state_of_another_learner_is_refused() -> None:
    saved = learner_of(small("ddqn")).state()
    with pytest.raises(InputError, match=r"the state holds float32 \(\d+,\) as 'online'"):
        learner_of(small("ddqn", hidden=(8,))).restore(saved)
    with pytest.raises(InputError, match="the state holds nothing as 'trees'"):
        learner_of(small("ddqn", replay="prioritised")).restore(saved)
    with pytest.raises(InputError, match="as 'online'"):
        learner_of(small("ddqn", memory=(0.1,))).restore(saved)


BESIDE_EACH_OTHER = pytest.mark.parametrize("name", ["ddqn", "hybrid-hrl-plus", "hybrid-hrl", "pqn"])


@BESIDE_EACH_OTHER
def test_learners_in_turn_learn_what_each_learns_alone(name: str) -> None:
    method, seeds = small(name, report_every=50), (3, 5)
    alone, beside = ([made(method, seed=seed) for seed in seeds] for _ in range(2))
    for learner in alone:
        list(learner.train(BUDGET))
    for _ in zip(*(learner.train(BUDGET) for learner in beside), strict=True):
        pass
    for learner, same in zip(beside, alone, strict=True):
        equal(state_of(learner), state_of(same))


@BESIDE_EACH_OTHER
def test_learners_in_threads_learn_what_each_learns_alone(name: str) -> None:
    method, seeds = small(name), (3, 5, 7)
    alone, beside = ([made(method, seed=seed) for seed in seeds] for _ in range(2))
    for learner in alone:
        list(learner.train(BUDGET))
    with ThreadPoolExecutor(len(seeds)) as pool:
        list(pool.map(lambda learner: list(learner.train(BUDGET)), beside))
    for learner, same in zip(beside, alone, strict=True):
        equal(state_of(learner), state_of(same))


@pytest.mark.parametrize("name", ["ddqn", "hybrid-hrl"])
@pytest.mark.parametrize("poison", [np.nan, np.inf])
def test_a_learner_that_is_not_finite_reports_it_and_leaves_the_other_alone(name: str, poison: float) -> None:
    method = small(name)
    sound, beside, sick = learner_of(method), learner_of(method), learner_of(method, seed=5)
    list(sound.train(BUDGET))
    ill, well = sick.train(BUDGET), beside.train(BUDGET)
    next(ill), next(well)
    sick.parameters.online[:] = poison
    (report,), _ = list(ill), list(well)
    equal(beside.state(), sound.state())
    assert not any(np.isfinite(loss) for loss in report.losses.values())


def test_values_that_no_rewards_allow_are_reported() -> None:
    learner = learner_of(small("ddqn"))
    next(training := learner.train(BUDGET))
    learner.parameters.online[-6:] = 1e6  # the biases of the values
    (report,) = training
    assert report.diverged is not None
    assert "the rewards allow" in report.diverged
