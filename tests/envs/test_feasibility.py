from dataclasses import replace

import numpy as np
import pytest

from hhrl_envs import SCENARIOS, Goal, Outcome, Scenario, Simulator
from hhrl_envs import layout as at

STOPS = [s for s in SCENARIOS.values() if s.goal == Goal.STOP and len(s.road.lines) == 1 and s.traffic.max_fronts > 0]


@pytest.mark.parametrize("scenario", STOPS, ids=lambda scenario: scenario.id)
def test_bounds_and_drive_agree_with_what_full_braking_meets(scenario: Scenario) -> None:
    rows = 1500
    simulator = Simulator(replace(scenario, feasible_only=False), rows)
    simulator.reset(np.arange(rows) + 10**6)
    feasible, cleared = simulator.feasible.copy(), np.full(rows, np.inf)
    constants, slot = scenario.constants(), int(at.VEHICLE) // at.STRIDE
    for step in range(scenario.horizon):
        rears = simulator._memory.fields[:, slot].ravel()[:rows] - scenario.vehicle.length
        cleared[(rears > scenario.road.lines[-1]) & np.isinf(cleared)] = step * scenario.dt
        simulator.step(np.zeros(rows, np.int64))
    expected = (simulator.outcomes != Outcome.COLLISION) & (cleared <= constants[at.CLEAR_BY])
    np.testing.assert_array_equal(feasible, expected)
