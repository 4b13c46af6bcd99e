"""Where a training begins: parameters taken over, levels that stay fixed, and starts that do not fit."""

from dataclasses import replace

import numpy as np
import pytest

from hhrl_agents.algorithms.double_dqn import DoubleDQNLearner
from hhrl_agents.methods.method import Method
from hhrl_agents.networks.architectures import Parameters
from hhrl_agents.policies.learned_agent import HierarchicalLearnedAgent
from hhrl_agents.training.learner import NOTHING, Start, make_learner
from hhrl_envs import InputError, get_scenario
from support.configs import small_methods
from support.small_training import CONFIG

MAIN, TARGET = get_scenario("stop-line-v0"), get_scenario("two-stops-v0")
METHODS = small_methods({**CONFIG, "report_every": 100})


def learner_of(method: Method, start: Start = NOTHING, seed: int = 3) -> DoubleDQNLearner:
    worlds = np.arange(method.config.n_envs, dtype=np.uint64)
    learner = make_learner(method, TARGET, seed, worlds, start=start)
    assert isinstance(learner, DoubleDQNLearner)
    return learner


def trained(method: Method, start: Start = NOTHING) -> Parameters:
    learner = learner_of(method, start)
    list(learner.train(400))
    assert learner.updates > 0
    return parameters_of(learner)


def parameters_of(learner: DoubleDQNLearner) -> Parameters:
    return learner.policy().parameters


def level(parameters: Parameters, name: str) -> Parameters:
    return {key: value for key, value in parameters.items() if key.startswith(f"{name}.")}


def equal(one: Parameters, other: Parameters) -> bool:
    return one.keys() == other.keys() and all(np.array_equal(value, other[name]) for name, value in one.items())


@pytest.mark.parametrize("name", ["ddqn", "hrl-0", "hybrid-hrl", "hybrid-hrl-plus"])
def test_a_learner_begins_with_the_parameters_that_it_takes_over(name: str) -> None:
    source = trained(METHODS[name])
    learner = learner_of(METHODS[name], Start(source), seed=5)
    assert not equal(source, parameters_of(learner_of(METHODS[name], seed=5)))
    assert equal(source, parameters_of(learner))
    np.testing.assert_array_equal(learner.parameters.target, learner.parameters.online)


@pytest.mark.parametrize("name", ["hrl-0", "hybrid-hrl", "hybrid-hrl-plus", "hybrid-hrl-per"])
@pytest.mark.parametrize(("fixed", "learned"), [("action", "option"), ("option", "action")])
def test_a_fixed_level_stays_as_it_was_and_the_other_one_learns(name: str, fixed: str, learned: str) -> None:
    carried = level(trained(METHODS[name]), fixed)
    drawn = parameters_of(learner_of(METHODS[name], Start(carried)))
    after = trained(METHODS[name], Start(carried, fixed=(fixed,)))
    assert equal(carried, level(after, fixed))
    assert not equal(level(drawn, learned), level(after, learned))


def test_what_is_not_taken_over_is_drawn_as_without_a_start() -> None:
    method = METHODS["hybrid-hrl"]
    carried = level(trained(method), "action")
    taken, nothing = parameters_of(learner_of(method, Start(carried))), parameters_of(learner_of(method))
    assert equal(level(nothing, "option"), level(taken, "option"))
    assert not equal(level(nothing, "action"), level(taken, "action"))


def test_a_start_of_its_own_parameters_learns_what_no_start_learns() -> None:
    method = METHODS["hybrid-hrl"]
    drawn = parameters_of(learner_of(method))
    assert equal(trained(method), trained(method, Start(drawn)))


def test_a_start_keeps_the_parameters_that_it_was_given() -> None:
    method = METHODS["ddqn"]
    given = parameters_of(learner_of(method))
    before = {name: value.copy() for name, value in given.items()}
    trained(method, Start(given))
    assert equal(given, before)


def test_a_fixed_action_level_always_takes_its_best_action_and_options_are_tried() -> None:
    method = METHODS["hybrid-hrl"]
    learner = learner_of(method, Start(parameters_of(learner_of(method)), fixed=("action",)))
    assert learner.levels == ["option"]
    tried = np.array([0, 1, 0, 1])
    options, actions = learner._choose({"option": tried})
    assert options.tolist() == tried.tolist()
    policy = learner.policy()
    assert isinstance(policy, HierarchicalLearnedAgent)
    policy.reset(np.ones(4, np.bool_))
    assert policy.act_with_option(learner._environments.features, tried).tolist() == actions.tolist()


def test_a_training_that_begins_with_little_exploration_meets_other_worlds_than_one_with_much() -> None:
    method = METHODS["ddqn"]
    drawn = parameters_of(learner_of(method))
    assert not equal(trained(method, Start(drawn, epsilon=0.0)), trained(method, Start(drawn)))


@pytest.mark.parametrize("epsilon", [-0.1, 1.5, float("nan")])
def test_an_epsilon_that_is_no_share_is_refused(epsilon: float) -> None:
    with pytest.raises(InputError, match=r"epsilon is .*; write a number in \[0, 1\]"):
        Start(epsilon=epsilon)


def test_a_start_that_does_not_fit_is_one_line() -> None:
    hybrid, flat = METHODS["hybrid-hrl"], METHODS["ddqn"]
    source = parameters_of(learner_of(hybrid))
    wider = replace(hybrid, config=replace(hybrid.config, hidden=(9,)))
    for method, start, said in (
        (wider, Start(source), r"shape \(1, 11, 8\) does not fit method 'hybrid-hrl', which has \(1, 11, 9\)"),
        (flat, Start(source), "which has no such parameter; start from a run of the same method"),
        (hybrid, Start(source, fixed=("option", "action")), "cannot stay fixed in method 'hybrid-hrl'"),
        (flat, Start(fixed=("option",)), "levels option cannot stay fixed in method 'ddqn', which learns action"),
    ):
        with pytest.raises(InputError, match=said):
            learner_of(method, start)


@pytest.mark.parametrize("name", ["pqn", "ppo"])
def test_learners_of_other_algorithms_begin_from_nothing(name: str) -> None:
    worlds = np.zeros(METHODS[name].config.n_envs, np.uint64)
    with pytest.raises(InputError, match=f"write none: {name} begins from nothing"):
        make_learner(METHODS[name], MAIN, 0, worlds, start=Start(epsilon=0.5))
