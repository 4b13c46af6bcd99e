from dataclasses import fields, replace

import numpy as np
import pytest

from hhrl_agents import RULES
from hhrl_agents.rules.rule_plus import RulePlus
from hhrl_agents.rules.tuned_rule import ALL_TASKS, ROBUST, TUNED, tunings
from hhrl_agents.rules.tuning import FIRST_TUNING, Tuning, bounds
from hhrl_envs import Scenario, Simulator, get_scenario
from hhrl_envs import observation as obs
from hhrl_envs.arrays import Ints

MAIN = get_scenario("stop-line-v0")
FOGGY = get_scenario("stop-line-dense-v0")


def observation(scenario: Scenario, **si: float) -> np.ndarray[tuple[int, int], np.dtype[np.float32]]:
    """An empty road 50 m before the line at 8 m/s, with the given elements changed."""
    usual = {"V_E": 8.0, "D_F": scenario.sensor.front_range, "V_F": scenario.road.speed_limit, "D_D": 50.0}
    row = np.zeros((1, obs.SIZE), np.float32)
    for name, value in (usual | si).items():
        row[0, getattr(obs, name)] = value
    return row * obs.SCALES


def level(scenario: Scenario, tuning: Tuning, **si: float) -> float:
    """The level that an agent with this tuning chooses, as an acceleration."""
    return scenario.vehicle.levels[int(RulePlus(scenario, tuning).act(observation(scenario, **si)).action[0])]


def driven(rule: str, scenario: Scenario, worlds: int = 50, steps: int = 40) -> Ints:
    """What a rule chooses in the first steps of worlds, [steps, worlds]."""
    simulator, agent = Simulator(scenario, worlds), RULES[rule](scenario)
    simulator.reset(np.arange(worlds))
    chosen = []
    for _ in range(steps):
        chosen.append(agent.act(simulator.observations).action)
        simulator.step(chosen[-1])
    return np.stack(chosen)


def test_every_number_has_bounds_and_the_first_guess_lies_within() -> None:
    numbers = [one.name for one in fields(Tuning) if one.type == "float" or one.type is float]
    assert list(bounds()) == numbers
    for name, (low, high, unit) in bounds().items():
        assert low <= getattr(FIRST_TUNING, name) <= high
        assert unit


@pytest.mark.parametrize("rule", [TUNED, ROBUST])
def test_what_is_stored_lies_within_the_bounds(rule: str) -> None:
    assert tunings(rule)
    for tuning in tunings(rule).values():
        assert all(low <= getattr(tuning, name) <= high for name, (low, high, _) in bounds().items())


def test_a_scenario_is_driven_by_the_numbers_found_for_it() -> None:
    own = RulePlus(MAIN, tunings(TUNED)[MAIN.id])
    simulator = Simulator(MAIN, 50)
    simulator.reset(np.arange(50))
    np.testing.assert_array_equal(own.act(simulator.observations).action, driven(TUNED, MAIN)[0])


def test_a_scenario_without_numbers_of_its_own_is_driven_by_those_for_all() -> None:
    mine = replace(MAIN, id="mine-v0")
    np.testing.assert_array_equal(driven(TUNED, mine), driven(ROBUST, mine))
    np.testing.assert_array_equal(driven(ROBUST, mine), driven(ROBUST, MAIN))
    assert list(tunings(ROBUST)) == [ALL_TASKS]


def test_held_out_drivers_are_met_with_the_numbers_of_the_main_task() -> None:
    rule, numbers = RULES[TUNED](get_scenario("stop-line-heldout-v0")), tunings(TUNED)["stop-line-v0"]
    assert isinstance(rule, RulePlus)
    own = RulePlus(get_scenario("stop-line-heldout-v0"), numbers)
    seen = np.concatenate([observation(MAIN, D_F=gap, V_F=4.0) for gap in range(6, 60)])
    np.testing.assert_array_equal(rule.act(seen).action, own.act(seen).action)


def test_the_share_of_the_speed_limit_is_the_top_speed() -> None:
    slow = replace(FIRST_TUNING, speed_share=0.5)
    assert level(MAIN, slow, D_D=90.0, V_E=7.0) < 0.0 < level(MAIN, FIRST_TUNING, D_D=90.0, V_E=7.0)


def test_a_front_vehicle_may_stand_just_out_of_sight() -> None:
    wary, trusting = (replace(FIRST_TUNING, hidden=share) for share in (0.0, 1.0))
    assert level(FOGGY, wary, V_E=12.0, D_D=90.0) < 0.0 < level(FOGGY, trusting, V_E=12.0, D_D=90.0)
    seen = {"V_E": 8.0, "D_D": 90.0, "D_F": 12.0, "V_F": 8.0}
    assert level(FOGGY, wary, **seen) == level(FOGGY, trusting, **seen)


def test_a_delay_is_predicted_as_far_as_its_share_says() -> None:
    closing = {"D_F": 15.0, "V_F": 8.0, "A_F": -3.0, "D_D": 90.0}
    short, long = (replace(FIRST_TUNING, delays=share) for share in (0.0, 1.0))
    assert level(FOGGY, long, **closing) < level(FOGGY, short, **closing)
    assert level(MAIN, long, **closing) == level(MAIN, short, **closing)  # its sensors are not late


def test_no_change_of_level_exceeds_the_jerk_unless_the_brakes_are_urgent() -> None:
    gentle = replace(FIRST_TUNING, jerk=4.13, urgent=5.0)
    assert level(MAIN, gentle, A_E=0.0, D_D=12.0, V_E=7.0) == -1.5
    assert level(MAIN, replace(gentle, jerk=30.0), A_E=0.0, D_D=12.0, V_E=7.0) == -3.0
    assert level(MAIN, gentle, A_E=0.0, D_D=4.0, V_E=8.0) == -6.0
