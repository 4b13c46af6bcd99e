from dataclasses import replace

import numpy as np
import pytest

from hhrl_agents import RULES, HierarchicalAgent
from hhrl_envs import Option, Outcome, Scenario, Simulator, get_scenario
from hhrl_envs import observation as obs
from hhrl_envs.arrays import Floats
from hhrl_envs.simulation.rewards import UNSAFE

MAIN = get_scenario("stop-line-v0")
ALONE = replace(MAIN, id="alone", traffic=replace(MAIN.traffic, count_shares=(1.0,)))
EPISODES = 500


def observations(**si: float) -> np.ndarray[tuple[int, int], np.dtype[np.float32]]:
    row = np.zeros((1, obs.SIZE), np.float32)
    for name, value in si.items():
        row[0, getattr(obs, name)] = value
    return row * obs.SCALES


def drive(rule: str, scenario: Scenario = MAIN) -> tuple[Floats, Simulator, Floats]:
    """Drive one episode in each of `EPISODES` worlds: outcome shares, the simulator at the end, summed terms."""
    simulator = Simulator(scenario, EPISODES)
    simulator.reset(np.arange(EPISODES) + 7_000)
    agent = RULES[rule](scenario)
    agent.reset(np.ones(EPISODES, np.bool_))
    terms = np.zeros_like(simulator.terms)
    while (simulator.outcomes == Outcome.RUNNING).any():
        simulator.step(agent.act(simulator.observations).action)
        terms += simulator.terms
    return np.bincount(simulator.outcomes, minlength=len(Outcome)) / EPISODES, simulator, terms


@pytest.mark.parametrize(
    ("rule", "d_d", "d_f", "d_fc", "option"),
    [
        ("rule-1", 10.0, 90.0, 85.0, Option.FFV),
        ("rule-2", 90.0, 10.0, 5.0, Option.SSL),
        ("rule-3", 15.1, 10.0, 5.0, Option.FFV),
        ("rule-3", 14.9, 10.0, 5.0, Option.SSL),
        ("rule-4", 5.1, 10.0, 5.0, Option.FFV),
        ("rule-4", 4.9, 10.0, 5.0, Option.SSL),
        ("rule-4-literal", 4.9, 10.0, 5.0, Option.FFV),
    ],
)
def test_rule_selects_by_its_inequality(rule: str, d_d: float, d_f: float, d_fc: float, option: Option) -> None:
    decision = RULES[rule](MAIN).act(observations(D_D=d_d, D_F=d_f, D_FC=d_fc, V_E=5.0))
    assert decision.option == option


@pytest.mark.parametrize("rule", RULES)
def test_action_is_that_of_the_selected_option(rule: str) -> None:
    simulator = Simulator(MAIN, 64)
    simulator.reset(np.arange(64))
    agent = RULES[rule](MAIN)
    decision = agent.act(simulator.observations)
    np.testing.assert_array_equal(agent.act_with_option(simulator.observations, decision.option), decision.action)
    assert isinstance(agent, HierarchicalAgent)


def test_held_options_give_the_rules_that_hold_them() -> None:
    simulator = Simulator(MAIN, 64)
    simulator.reset(np.arange(64))
    for rule, option in (("rule-1", Option.FFV), ("rule-2", Option.SSL)):
        held = RULES["rule-4"](MAIN).act_with_option(simulator.observations, np.full(64, option))
        np.testing.assert_array_equal(held, RULES[rule](MAIN).act(simulator.observations).action)


def test_rule_1_never_stops_at_the_line() -> None:
    shares, _, terms = drive("rule-1")
    assert shares[Outcome.NOT_STOP] > 0.9
    assert np.mean(terms[:, UNSAFE[Option.FFV]] < 0.0) < 0.08


def test_rule_2_drives_into_the_queue() -> None:
    shares, _, _ = drive("rule-2")
    assert shares[Outcome.COLLISION] > 0.5


@pytest.mark.parametrize("rule", ["rule-3", "rule-4"])
def test_choosing_rules_reach_ordinary_competence(rule: str) -> None:
    shares, _, terms = drive(rule)
    assert shares[Outcome.SUCCESS] > 0.98
    assert terms[:, UNSAFE[Option.SSL]].sum() == 0.0


def test_rule_4_mostly_keeps_more_than_the_safe_gap() -> None:
    _, _, terms = drive("rule-4")
    assert np.mean(terms[:, UNSAFE[Option.FFV]] < 0.0) < 0.08


def test_ssl_stops_alone_on_the_road_without_creeping() -> None:
    shares, simulator, terms = drive("rule-2", ALONE)
    assert shares[Outcome.SUCCESS] == 1.0
    assert terms[:, UNSAFE[Option.SSL]].sum() == 0.0
    assert simulator.steps.max() < 200


def test_an_absent_option_is_not_selected() -> None:
    assert ALONE.option_mask == (True, False)
    decision = RULES["rule-1"](ALONE).act(observations(D_D=50.0, D_F=100.0, D_FC=95.0, V_E=5.0))
    assert decision.option == Option.SSL
