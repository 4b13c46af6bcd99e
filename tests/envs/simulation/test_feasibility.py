from dataclasses import replace
from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hhrl_envs import SCENARIOS, Adversary, Goal, Outcome, Scenario, Simulator, Slippery, get_scenario
from hhrl_envs.simulation.constants import pack
from hhrl_envs.simulation.engine import layout as at
from support.braking import braking_distance, longest_braking
from support.hidden import SLIPPERY
from support.recording import LEARNED, recorded
from support.reference import feasible

STOPS = [s for s in SCENARIOS.values() if s.goal == Goal.STOP and len(s.road.lines) == 1 and s.traffic.max_fronts > 0]


ICY = [
    replace(
        scenario,
        id=f"{scenario.id}-{low}-{high}",
        road=replace(scenario.road, slippery=Slippery(0.9, (low, high))),
        traffic=replace(scenario.traffic, gap=(4.0, 25.0)),
    )
    for low, high in ((0.01, 0.05), (0.05, 0.2), (0.15, 0.5))
    for scenario in (SLIPPERY, get_scenario("stop-line-dense-v0"))
]


@pytest.mark.parametrize("scenario", [*STOPS, *ICY], ids=lambda scenario: scenario.id)
def test_bounds_and_drive_agree_with_what_full_braking_meets(scenario: Scenario) -> None:
    rows = 1500
    simulator = Simulator(replace(scenario, feasible_only=False), rows)
    simulator.reset(np.arange(rows) + 10**6)
    verdicts, cleared = simulator.feasible.copy(), np.full(rows, np.inf)
    constants, slot = pack(scenario), int(at.ROW + at.VEHICLE) // at.STRIDE
    for step in range(scenario.horizon):
        rears = simulator._memory.fields[:, slot].ravel()[:rows] - scenario.vehicle.length
        stands = simulator.motion(0)[:, 1] == 0.0  # on ice that may take longer than the queue does
        cleared[(rears > scenario.road.lines[-1]) & stands & np.isinf(cleared)] = step * scenario.dt
        simulator.step(np.zeros(rows, np.int64))
    too_far = simulator.motion(0)[:, 0] > scenario.road.lines[0]
    unavoidable = (simulator.outcomes == Outcome.COLLISION) | too_far
    expected = ~unavoidable & (cleared <= constants[at.CLEAR_BY])
    np.testing.assert_array_equal(verdicts, expected)


@pytest.mark.parametrize(("scenario_id", "fronts"), [each for each in LEARNED if get_scenario(each[0]) in STOPS])
def test_with_learned_fronts_the_verdict_is_that_of_an_independent_shadow(scenario_id: str, fronts: int) -> None:
    tape = recorded(scenario_id, fronts)
    rears = tape.vehicles[:, :, 1, 0] - tape.scenario.vehicle.length
    for row, end in enumerate(tape.ends()[0]):
        start = tuple(tape.vehicles[0, row, 0, :2])
        verdict = bool(tape.feasible[end, row])
        assert verdict == feasible(tape.scenario, start, rears[: end + 1, row])
        assert (tape.feasible[end:, row] == verdict).all(), "it changed after the ego's end"


def test_the_recordings_hold_both_verdicts() -> None:
    verdicts = {bool(each) for scenario_id, fronts in LEARNED for each in recorded(scenario_id, fronts).feasible[-1]}
    assert verdicts == {True, False}


def test_a_front_vehicle_that_brakes_before_the_ego_can_makes_its_episode_infeasible() -> None:
    scenario = get_scenario("adversary-v0")
    hasty = replace(
        scenario,
        traffic=replace(scenario.traffic, gap=(1.0, 2.0), speed=(0.0, 1.0)),
        road=replace(scenario.road, start_speed=(9.0, 12.0)),
    )
    simulator = Simulator(hasty, 8, learned_fronts=1)
    simulator.reset(np.arange(8))
    while (simulator.outcomes == Outcome.RUNNING).any():
        simulator.step(np.zeros((8, 2), np.int64))
    assert (simulator.outcomes == Outcome.COLLISION).all()
    assert not simulator.feasible.any()
    assert (simulator.of_agent(1).outcomes == Outcome.FOILED).all()


@pytest.mark.parametrize(("waits", "could"), [(0, True), (150, False)])
def test_a_line_that_is_never_freed_in_time_counts_however_the_ego_ends(waits: int, could: bool) -> None:
    scenario = replace(get_scenario("adversary-v0"), horizon=200, adversary=Adversary(patience=1000.0))
    simulator = Simulator(scenario, 8, learned_fronts=1)
    simulator.reset(np.arange(8))
    for step in range(200):
        simulator.step(np.tile([0 if step < waits else 5, 0], (8, 1)))
    collided = simulator.outcomes == Outcome.COLLISION
    assert collided.any()
    assert (simulator.feasible[collided] == could).all()
    assert (simulator.of_agent(1).outcomes[collided] == (Outcome.SUCCESS if could else Outcome.FOILED)).all()


@settings(deadline=None)
@given(st.floats(0, 60), st.floats(-9, -1), st.floats(0.05, 1.5), st.floats(0, 3), st.floats(0.5, 60))
def test_nobody_brakes_longer_than_the_bound(
    speed: float, brake: float, friction: float, lag: float, jerk_limit: float
) -> None:
    main = get_scenario("stop-line-v0")
    vehicle = replace(main.vehicle, levels=(brake, 0.0, 2.0), max_decel=-brake, lag=lag, jerk_limit=jerk_limit)
    c, grip = pack(replace(main, vehicle=vehicle, horizon=20_000)), friction * 9.81
    assert braking_distance(speed, grip, c) <= longest_braking(speed, grip, c) + 1e-9


def test_who_does_not_stand_within_the_time_limit_brakes_for_ever() -> None:
    main = get_scenario("stop-line-v0")
    short, enough = (pack(replace(main, horizon=horizon, feasible_only=False)) for horizon in (10, 100))
    assert braking_distance(10.0, 9.81, short) == inf
    assert 8.0 < braking_distance(10.0, 9.81, enough) < 20.0
    assert braking_distance(0.0, 9.81, short) == 0.0
