"""Who drives which vehicle: actions and results go to the right slots."""

from collections.abc import Mapping

import numpy as np
import pytest

from hhrl_agents import RULES, Decision
from hhrl_agents.training.drivers import EGO_ALONE, Drivers
from hhrl_envs import InputError, Simulator, get_scenario
from hhrl_envs.arrays import Flags, Floats32
from hhrl_envs.simulation.simulator import Results

PLATOON, ADVERSARY = get_scenario("platoon-v0"), get_scenario("adversary-v0")
ROWS = 7


class Constant:
    """An agent that always chooses one level, and notes what it is told."""

    def __init__(self, action: int) -> None:
        self.action = action
        self.seen: list[Floats32] = []
        self.begun: list[Flags] = []

    def reset(self, mask: Flags) -> None:
        self.begun.append(mask)

    def act(self, observations: Floats32) -> Decision:
        self.seen.append(observations)
        return Decision(np.full(len(observations), -1), np.full(len(observations), self.action))


def begun(drivers: Drivers, scenario: str) -> Simulator:
    simulator = drivers.simulator(get_scenario(scenario), ROWS)
    simulator.reset(np.arange(ROWS))
    return simulator


def test_the_ego_alone_is_a_simulator_with_one_agent() -> None:
    simulator = begun(EGO_ALONE, "stop-line-v0")
    assert simulator.num_agents == 1
    own = np.arange(ROWS) % 6
    assert EGO_ALONE.actions(simulator, own) is own
    for part, expected in zip(EGO_ALONE.results(simulator), simulator.of_agent(0), strict=True):
        np.testing.assert_array_equal(part, expected)


def test_the_results_of_a_row_s_vehicles_stand_side_by_side() -> None:
    drivers = Drivers((0, 1, 2, 3))
    simulator = begun(drivers, "platoon-v0")
    own = np.random.default_rng(0).integers(0, 6, 4 * ROWS)
    actions = drivers.actions(simulator, own)
    np.testing.assert_array_equal(actions, own.reshape(ROWS, 4))
    simulator.step(actions)
    results = drivers.results(simulator)
    for slot in range(4):
        for field in Results._fields:
            own_part, expected = getattr(results, field)[slot::4], getattr(simulator.of_agent(slot), field)
            np.testing.assert_array_equal(own_part, expected)


@pytest.mark.parametrize(("own", "other"), [(0, 1), (1, 0)])
def test_another_driver_sees_and_drives_its_own_vehicle(own: int, other: int) -> None:
    agent = Constant(4)
    drivers = Drivers((own,), {other: agent})
    simulator = begun(drivers, "adversary-v0")
    drivers.begin(np.ones(ROWS, np.bool_))
    expected = np.empty((ROWS, 2), np.int64)
    expected[:, own], expected[:, other] = np.arange(ROWS) % 6, 4
    np.testing.assert_array_equal(drivers.actions(simulator, np.arange(ROWS) % 6), expected)
    np.testing.assert_array_equal(agent.seen[0], simulator.of_agent(other).observations)
    assert agent.begun[0].all()


@pytest.mark.parametrize(
    ("slots", "others", "message"),
    [
        ((1,), {}, r"drives the vehicles \[1\]; name each of 0 to 1 once"),
        ((0, 1), {1: RULES["rule-4"](ADVERSARY)}, r"\[0, 1, 1\]"),
        ((0, 1, 2), {}, "learned_fronts is 2; write 0 to 0 for scenario 'solo-stop-v0'|learned_fronts"),
    ],
)
def test_drivers_that_cannot_be_are_refused(
    slots: tuple[int, ...], others: Mapping[int, Constant], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        Drivers(slots, others).simulator(get_scenario("solo-stop-v0"), 1)
