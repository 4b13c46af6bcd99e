"""Training by torch beside the compiled learner: the same loop, gradient steps that differ in rounding alone."""

from typing import Any

import numpy as np
import pytest

from hhrl_agents import METHODS
from hhrl_agents.algorithms.double_dqn import DoubleDQNLearner
from hhrl_agents.methods.method import Method
from hhrl_agents.reference.learner import TorchLearner
from hhrl_envs import InputError, get_scenario
from support.configs import with_values

MAIN = get_scenario("stop-line-v0")
SMALL: dict[str, Any] = {
    "hidden": (16, 16),
    "n_envs": 4,
    "batch_size": 16,
    "replay_capacity": 1_000,
    "warmup": 40,
    "target_interval": 3,
    "report_every": 40,
}
WORLDS = np.arange(4, dtype=np.uint64)


def small(name: str) -> Method:
    return with_values(METHODS[name], SMALL)


@pytest.mark.parametrize("name", ["ddqn", "hybrid-hrl", "hybrid-hrl-plus", "rule-option", "option-only", "ddqn-per"])
def test_it_learns_what_the_compiled_learner_does(name: str) -> None:
    learners = [kind(small(name), MAIN, 3, WORLDS) for kind in (DoubleDQNLearner, TorchLearner)]
    reports = [list(learner.train(80)) for learner in learners]
    compiled, torch = (learner.policy().parameters for learner in learners)
    assert learners[0].updates == learners[1].updates == 10
    for level, loss in reports[0][-1].losses.items():
        assert reports[1][-1].losses[level] == pytest.approx(loss, rel=1e-3)
    for parameter, value in compiled.items():
        np.testing.assert_allclose(torch[parameter], value, rtol=1e-3, atol=1e-4, err_msg=parameter)
    untrained = DoubleDQNLearner(small(name), MAIN, 3, WORLDS).policy().parameters
    learned = [parameter for parameter, value in untrained.items() if not np.array_equal(torch[parameter], value)]
    assert {parameter.split(".")[0] for parameter in learned} == set(METHODS[name].levels)


def test_it_says_which_torch_and_is_not_saved() -> None:
    learner = TorchLearner(small("ddqn"), MAIN, 3, WORLDS)
    list(learner.train(80))
    assert "torch" in learner.policy().metadata["versions"]
    assert learner.state() is None
    with pytest.raises(InputError, match="cannot go on from a state"):
        learner.restore({})


def test_other_algorithms_and_devices_are_refused() -> None:
    with pytest.raises(InputError, match="method is 'pqn'; write one that learns by double-dqn"):
        TorchLearner(METHODS["pqn"], MAIN, 3, np.arange(32, dtype=np.uint64))
    with pytest.raises(InputError, match="torch cannot compute on device 'nowhere'"):
        TorchLearner(small("ddqn"), MAIN, 3, WORLDS, device="nowhere")
