"""A learner's state: a fresh learner that takes it up goes on to the same bits."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from hhrl_agents import METHODS  # noqa: E402
from hhrl_agents.algorithms.double_dqn import DoubleDQNLearner  # noqa: E402
from hhrl_agents.methods.method import Method  # noqa: E402
from hhrl_agents.policies import checkpoints  # noqa: E402
from hhrl_agents.policies.checkpoint_file import SHIPPED  # noqa: E402
from hhrl_agents.training.drivers import EGO_ALONE, Drivers  # noqa: E402
from hhrl_agents.training.learner import Learner, make_learner  # noqa: E402
from hhrl_envs import InputError, get_scenario  # noqa: E402
from hhrl_envs.state import State  # noqa: E402
from support.configs import with_values  # noqa: E402

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


def stack_of(method: Method, scenario: str = "stop-line-v0") -> Learner:
    worlds = np.arange(8, dtype=np.uint64).reshape(2, 4)
    return make_learner(method, get_scenario(scenario), (3, 5), worlds, drivers=drivers_of(scenario))


def learner_of(method: Method) -> DoubleDQNLearner:
    learner = stack_of(method)
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
    whole = stack_of(method, scenario)
    reports = list(whole.train(BUDGET))
    stopped = stack_of(method, scenario)
    first = next(training := stopped.train(BUDGET))
    saved = state_of(stopped)
    kept = {name: array.copy() for name, array in saved.items()}
    list(training)
    equal(saved, kept)
    fresh = stack_of(method, scenario)
    fresh.restore(saved)
    (second,) = fresh.train(BUDGET)
    equal(state_of(whole), state_of(fresh))
    for report, same in zip(reports, (first, second), strict=True):
        assert (report.env_steps, report.updates) == (same.env_steps, same.updates)
        np.testing.assert_array_equal(report.outcome_counts, same.outcome_counts)
        np.testing.assert_array_equal(list(report.losses.values()), list(same.losses.values()))


def test_the_state_of_another_learner_is_refused() -> None:
    saved = learner_of(small("ddqn")).state()
    with pytest.raises(InputError, match=r"the state holds float32 \(2, .*\) as 'online'"):
        learner_of(small("ddqn", hidden=(8,))).restore(saved)
    with pytest.raises(InputError, match="the state holds nothing as 'trees'"):
        learner_of(small("ddqn", replay="prioritised")).restore(saved)
    with pytest.raises(InputError, match="as 'online'"):
        learner_of(small("ddqn", memory=(0.1,))).restore(saved)


@pytest.mark.parametrize("name", ["ddqn", "hybrid-hrl"])
@pytest.mark.parametrize("poison", [np.nan, np.inf])
def test_a_seed_that_is_not_finite_leaves_the_other_alone(name: str, poison: float) -> None:
    method = small(name)
    sound, sick = learner_of(method), learner_of(method)
    next(training := sick.train(BUDGET))
    sick.stack.flat[1] = poison
    (report,) = training
    *_, expected = sound.train(BUDGET)
    assert torch.equal(sick.stack.flat[0], sound.stack.flat[0])
    for level, losses in expected.losses.items():
        assert report.losses[level][0] == losses[0]
        assert not np.isfinite(report.losses[level][1])


def test_values_that_no_rewards_allow_are_reported() -> None:
    learner = learner_of(small("ddqn"))
    next(training := learner.train(BUDGET))
    learner.stack.online["action.2.bias"][1] = 1e6
    (report,) = training
    assert list(report.diverged) == [1]
    assert "the rewards allow" in report.diverged[1]
