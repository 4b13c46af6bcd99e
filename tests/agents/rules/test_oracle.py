from dataclasses import replace

import numpy as np
import pytest

from hhrl_agents.agent import ClairvoyantAgent
from hhrl_agents.rules.oracle import COMFORTABLE, Manner, Oracle, Plans, foresee, quicker, quickest
from hhrl_agents.rules.rule_plus import RulePlus
from hhrl_agents.rules.tuning import Tuning
from hhrl_envs import SCENARIOS, Goal, InputError, Outcome, Scenario, Simulator, get_scenario
from hhrl_envs.arrays import Ints
from support.hidden import HIDDEN

WORLDS = 100
KNOWN = {**SCENARIOS, **HIDDEN}
SCRIPTED = [name for name, scenario in KNOWN.items() if not scenario.learned_fronts]
STOPS = [name for name in SCRIPTED if KNOWN[name].goal != Goal.FOLLOW]
DISCRETISATION = 4  # steps; what levels, steps and the actuator's lag may cost a plan


def begun(scenario: Scenario, worlds: int = WORLDS, first: int = 40_000) -> Simulator:
    simulator = Simulator(scenario, worlds)
    simulator.reset(np.arange(worlds) + first)
    return simulator


def drive(agent: Oracle | RulePlus, simulator: Simulator) -> Simulator:
    if isinstance(agent, ClairvoyantAgent):
        agent.foresee(simulator)
    agent.reset(np.ones(simulator.num_rows, np.bool_))
    while (simulator.outcomes == Outcome.RUNNING).any():
        simulator.step(agent.act(simulator.observations).action)
    return simulator


def fewest(name: str) -> Ints:
    agent = Oracle(KNOWN[name])
    agent.foresee(begun(agent._scenario))
    return agent.fewest


@pytest.mark.parametrize("name", SCRIPTED)
def test_it_succeeds_wherever_anyone_can(name: str) -> None:
    simulator = drive(Oracle(KNOWN[name]), begun(KNOWN[name]))
    assert (simulator.outcomes[simulator.feasible] == Outcome.SUCCESS).all()


@pytest.mark.parametrize("name", SCRIPTED)
def test_its_plans_take_as_long_as_the_simulator_does(name: str) -> None:
    simulator = begun(KNOWN[name])
    plans = quickest(foresee(simulator), simulator.scenario)
    found = plans.steps > 0
    for actions in plans.actions.T:
        simulator.step(actions.astype(np.int64))
    assert (simulator.outcomes[found] == Outcome.SUCCESS).all()
    np.testing.assert_array_equal(simulator.steps[found], plans.steps[found])
    assert found[simulator.feasible].all()


@pytest.mark.parametrize("name", STOPS)
def test_nobody_is_quicker(name: str) -> None:
    rng, scenario, quick = np.random.default_rng(5), KNOWN[name], fewest(name)
    for _ in range(4):
        headway, margin = rng.uniform(0.2, 1.5), rng.uniform(-4.5, 1.0)
        tuning = Tuning(headway, rng.uniform(1.5, 5.0), margin, rng.uniform(0.3, 1.0), rng.uniform(1.5, 4.0))
        simulator = drive(RulePlus(scenario, tuning), begun(scenario))
        there = simulator.outcomes == Outcome.SUCCESS
        assert (simulator.steps[there] >= quick[there] - DISCRETISATION).all()


def test_it_is_comfortable_where_that_leads_to_the_goal() -> None:
    simulator, agent = begun(get_scenario("stop-line-v0")), Oracle(get_scenario("stop-line-v0"))
    agent.foresee(simulator)
    levels = np.array(simulator.scenario.vehicle.levels)
    comfortable = quickest(foresee(simulator), simulator.scenario, Manner(0.0, *COMFORTABLE))
    used = levels[agent._actions[comfortable.steps > 0]]
    assert COMFORTABLE[0] <= used.min() < used.max() <= COMFORTABLE[1]
    assert (agent.fewest <= comfortable.steps)[comfortable.steps > 0].all()


def test_it_leaves_the_worlds_as_they_are() -> None:
    simulator, untouched = begun(get_scenario("stop-line-noisy-v0")), begun(get_scenario("stop-line-noisy-v0"))
    Oracle(simulator.scenario).foresee(simulator)
    for _ in range(5):
        np.testing.assert_array_equal(simulator.observations, untouched.observations)
        for one in (simulator, untouched):
            one.step(np.full(WORLDS, 3))


def test_where_nobody_can_succeed_it_finds_no_way() -> None:
    scenario = get_scenario("stop-line-v0")
    near = replace(scenario.road, start_distance=(5.0, 5.0), start_speed=(12.0, 12.0))
    simulator = begun(replace(scenario, id="too-near", road=near, feasible_only=False))
    agent = Oracle(simulator.scenario)
    agent.foresee(simulator)
    assert not simulator.feasible.any()
    assert not agent.fewest.any()


def test_of_equal_plans_the_first_is_taken() -> None:
    simulator = begun(get_scenario("solo-stop-v0"), 3)
    one = quickest(foresee(simulator), simulator.scenario)
    other = Plans(one.steps + np.array([0, -1, 1]), one.actions + np.int8(1))
    best = quicker(one, other)
    np.testing.assert_array_equal(best.steps, one.steps + np.array([0, -1, 0]))
    np.testing.assert_array_equal(best.actions[:, 0], one.actions[:, 0] + [0, 1, 0])


def test_learned_front_vehicles_cannot_be_foreseen() -> None:
    simulator = Simulator(get_scenario("platoon-v0"), 2, learned_fronts=1)
    simulator.reset(np.arange(2))
    with pytest.raises(InputError, match="the oracle foresees scripted traffic alone"):
        foresee(simulator)
