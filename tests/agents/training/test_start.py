"""Where a training begins: parameters taken over, levels that stay fixed, and starts that do not fit."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from hhrl_agents.algorithms.double_dqn import DoubleDQNLearner
from hhrl_agents.methods.method import Method
from hhrl_agents.networks.architectures import Parameters
from hhrl_agents.training.learner import NOTHING, Start, make_learner
from hhrl_envs import InputError, get_scenario
from hhrl_envs.arrays import Floats32
from support.configs import small_methods
from support.small_training import CONFIG

MAIN, TARGET = get_scenario("stop-line-v0"), get_scenario("two-stops-v0")
SEEDS = (3, 5)
METHODS = small_methods({**CONFIG, "report_every": 100})
Taken = list[dict[str, Floats32]]


def learner_of(method: Method, start: Start = NOTHING) -> DoubleDQNLearner:
    worlds = np.arange(len(SEEDS) * method.config.n_envs, dtype=np.uint64).reshape(len(SEEDS), -1)
    learner = make_learner(method, TARGET, SEEDS, worlds, start=start)
    assert isinstance(learner, DoubleDQNLearner)
    return learner


def trained(method: Method, start: Start = NOTHING) -> Taken:
    learner = learner_of(method, start)
    list(learner.train(400))
    assert learner.updates > 0
    return parameters_of(learner)


def parameters_of(learner: DoubleDQNLearner) -> Taken:
    return [policy.parameters for policy in learner.policies()]


def level(parameters: Parameters, name: str) -> dict[str, Floats32]:
    return {key: value for key, value in parameters.items() if key.startswith(f"{name}.")}


def equal(one: Parameters, other: Parameters) -> bool:
    return one.keys() == other.keys() and all(np.array_equal(value, other[name]) for name, value in one.items())


@pytest.mark.parametrize("name", ["ddqn", "hrl-0", "hybrid-hrl", "hybrid-hrl-plus"])
def test_every_seed_begins_with_the_parameters_that_it_takes_over(name: str) -> None:
    source = trained(METHODS[name])
    learner = learner_of(METHODS[name], Start(source))
    assert not equal(source[0], source[1])
    for given, taken in zip(source, parameters_of(learner), strict=True):
        assert equal(given, taken)
    torch.testing.assert_close(learner.stack.flat_target, learner.stack.flat, rtol=0, atol=0)


@pytest.mark.parametrize("name", ["hrl-0", "hybrid-hrl", "hybrid-hrl-plus", "hybrid-hrl-per"])
@pytest.mark.parametrize(("fixed", "learned"), [("action", "option"), ("option", "action")])
def test_a_fixed_level_stays_as_it_was_and_the_other_one_learns(name: str, fixed: str, learned: str) -> None:
    source = trained(METHODS[name])
    carried = [level(parameters, fixed) for parameters in source]
    drawn = parameters_of(learner_of(METHODS[name], Start(carried)))
    after = trained(METHODS[name], Start(carried, fixed=(fixed,)))
    for given, before, parameters in zip(carried, drawn, after, strict=True):
        assert equal(given, level(parameters, fixed))
        assert not equal(level(before, learned), level(parameters, learned))


def test_what_is_not_taken_over_is_drawn_as_without_a_start() -> None:
    method = METHODS["hybrid-hrl"]
    nothing = parameters_of(learner_of(method))
    carried = [level(parameters, "action") for parameters in trained(method)]
    for drawn, parameters in zip(nothing, parameters_of(learner_of(method, Start(carried))), strict=True):
        assert equal(level(drawn, "option"), level(parameters, "option"))


def test_a_start_of_its_own_parameters_learns_what_no_start_learns() -> None:
    method = METHODS["hybrid-hrl"]
    drawn = parameters_of(learner_of(method))
    for one, other in zip(trained(method), trained(method, Start(drawn)), strict=True):
        assert equal(one, other)


def test_a_fixed_action_level_always_takes_its_best_action_and_options_are_tried() -> None:
    method = METHODS["hybrid-hrl"]
    learner = learner_of(method, Start(parameters_of(learner_of(method)), fixed=("action",)))
    assert tuple(learner.algorithm.levels) == ("option",)
    observations = np.random.default_rng(0).normal(size=(2, 4, 11)).astype(np.float32)
    tried = np.array([[0, 1, 0, 1], [1, 1, 0, 0]])
    options, actions = learner.algorithm.choose(observations, (tried,))
    assert options.tolist() == tried.tolist()
    for index, policy in enumerate(learner.policies()):
        assert policy.act_with_option(observations[index], tried[index]).tolist() == actions[index].tolist()  # type: ignore[attr-defined]


def test_a_training_that_begins_with_little_exploration_meets_other_worlds_than_one_with_much() -> None:
    method = METHODS["ddqn"]
    drawn = parameters_of(learner_of(method))
    assert not equal(trained(method, Start(drawn, epsilon=0.0))[0], trained(method, Start(drawn))[0])


@pytest.mark.parametrize("epsilon", [-0.1, 1.5, float("nan")])
def test_an_epsilon_that_is_no_share_is_refused(epsilon: float) -> None:
    with pytest.raises(InputError, match=r"epsilon is .*; write a number in \[0, 1\]"):
        Start(epsilon=epsilon)


def test_a_start_that_does_not_fit_is_one_line() -> None:
    hybrid, flat = METHODS["hybrid-hrl"], METHODS["ddqn"]
    source = parameters_of(learner_of(hybrid))
    wider = replace(hybrid, config=replace(hybrid.config, hidden=(9,)))
    for method, start, said in (
        (hybrid, Start(source[:1]), "a start for 1 seeds does not fit 2; give one for each seed"),
        (wider, Start(source), r"shape \(1, 11, 8\) does not fit method 'hybrid-hrl', which has \(1, 11, 9\)"),
        (flat, Start(source), "which has no such parameter; start from a run of the same method"),
        (hybrid, Start(source, fixed=("option", "action")), "cannot stay fixed in method 'hybrid-hrl'"),
        (flat, Start(fixed=("option",)), "levels option cannot stay fixed in method 'ddqn', which learns action"),
    ):
        with pytest.raises(InputError, match=said):
            learner_of(method, start)


@pytest.mark.parametrize("name", ["pqn", "ppo"])
def test_learners_of_other_algorithms_begin_from_nothing(name: str) -> None:
    worlds = np.zeros((1, METHODS[name].config.n_envs), np.uint64)
    with pytest.raises(InputError, match=f"write none: {name} begins from nothing"):
        make_learner(METHODS[name], MAIN, (0,), worlds, start=Start(epsilon=0.5))
