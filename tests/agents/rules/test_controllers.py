from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hhrl_agents.rules.controllers import (
    CONTROLLERS,
    FollowFrontVehicle,
    KeepSafeSpeed,
    StopAtStopLine,
    nearest_levels,
    smooth_levels,
)
from hhrl_agents.rules.tuning import FIRST_TUNING
from hhrl_envs import SUB_GOALS, get_scenario
from hhrl_envs import observation as obs

MAIN = get_scenario("stop-line-v0")
LEVELS = np.array(MAIN.vehicle.levels)


def state(**values: float) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """One SI state on an empty road, 50 m before the line, with the given elements changed."""
    usual = {"V_E": 8.0, "D_F": MAIN.sensor.front_range, "V_F": MAIN.road.speed_limit, "D_D": 50.0}
    row = np.zeros((1, obs.SIZE))
    for name, value in (usual | values).items():
        row[0, getattr(obs, name)] = value
    return row


@settings(deadline=None)
@given(st.lists(st.floats(-20, 20), min_size=1, max_size=9))
def test_nearest_level_is_nearest(accelerations: list[float]) -> None:
    wanted = np.array(accelerations)
    chosen = nearest_levels(LEVELS, wanted)
    np.testing.assert_allclose(
        np.abs(LEVELS[chosen] - wanted), np.abs(LEVELS[None, :] - wanted[:, None]).min(axis=1), atol=1e-12
    )


def test_nearest_level_on_a_tie_is_the_lower_one() -> None:
    assert LEVELS[nearest_levels(LEVELS, np.array([1.5]))] == 1.0
    assert LEVELS[nearest_levels(LEVELS, np.array([-0.75]))] == -1.5


@pytest.mark.parametrize("way", [0.5, 3.0, 10.0, 40.0])
def test_ssl_moves_up_when_standing_before_the_stop_zone(way: float) -> None:
    wanted = StopAtStopLine.for_scenario(MAIN)(state(V_E=0.0, D_D=MAIN.road.stop_zone + way))
    assert LEVELS[nearest_levels(LEVELS, wanted)] > 0


@pytest.mark.parametrize("way", [-5.0, 0.2, 1.0])
def test_ssl_brakes_at_its_aim_and_beyond(way: float) -> None:
    assert StopAtStopLine.for_scenario(MAIN)(state(V_E=1.0, D_D=way)) < -1.5


def test_ssl_drives_at_the_speed_limit_far_from_the_line() -> None:
    controller = StopAtStopLine.for_scenario(MAIN)
    assert abs(controller(state(V_E=MAIN.road.speed_limit, D_D=90.0))[0]) < 1e-9
    assert controller(state(V_E=5.0, D_D=90.0)) > 2.0


def test_ffv_drives_at_the_speed_limit_without_a_front_vehicle() -> None:
    controller = FollowFrontVehicle.for_scenario(MAIN)
    assert abs(controller(state(V_E=MAIN.road.speed_limit))[0]) < 0.5
    assert controller(state(V_E=2.0)) > 1.5


def test_ffv_brakes_harder_the_nearer_the_front_vehicle_stands() -> None:
    controller = FollowFrontVehicle.for_scenario(MAIN)
    wanted = [controller(state(V_F=0.0, D_F=gap))[0] for gap in (60.0, 30.0, 20.0, 12.0)]
    assert wanted == sorted(wanted, reverse=True)
    assert wanted[-1] < -3.0


def test_ffv_stands_still_within_its_standstill_gap() -> None:
    controller = FollowFrontVehicle.for_scenario(MAIN)
    assert controller(state(V_E=0.0, V_F=0.0, D_F=MAIN.reward.safe_gap)) < 0.0


def test_ffv_survives_a_gap_of_zero() -> None:
    assert np.isfinite(FollowFrontVehicle.for_scenario(MAIN)(state(D_F=0.0))).all()


def test_every_sub_goal_has_a_controller() -> None:
    assert list(CONTROLLERS) == [sub_goal.option for sub_goal in SUB_GOALS]


def safe(**changed: Any) -> KeepSafeSpeed:
    return KeepSafeSpeed.for_scenario(MAIN, replace(FIRST_TUNING, **changed))


def test_a_safe_speed_leaves_room_to_stop_behind_a_front_vehicle_that_brakes() -> None:
    controller = safe(headway=1.0, front_decel=2.0, leader_decel=4.0, gap_margin=0.0, speed_share=1.0)
    for gap, front_speed in ((20.0, 0.0), (15.0, 6.0), (30.0, 3.0)):
        room = gap - MAIN.reward.safe_gap + front_speed**2 / 8.0
        speed = np.sqrt(4.0 + 4.0 * room) - 2.0
        slower, faster = (controller(state(D_F=gap, V_F=front_speed, V_E=speed + by))[0] for by in (-0.1, 0.1))
        constant = -2.0 * (speed - front_speed) / (speed + 2.0)
        assert faster < constant < slower
        np.testing.assert_allclose(speed * 1.0 + speed**2 / 4.0, room)


def test_a_follower_starts_with_its_front_vehicle_and_brakes_with_it() -> None:
    waiting = {"V_E": 0.0, "D_F": MAIN.reward.safe_gap}
    assert safe()(state(V_F=0.0, **waiting)) <= 0.0 < safe()(state(V_F=1.0, **waiting))
    steady, braking = (safe()(state(D_F=15.0, V_F=8.0, A_F=accel)) for accel in (0.0, -3.0))
    assert braking < steady


def test_a_safe_speed_is_at_most_the_share_of_the_limit_and_accelerates_as_it_is_told() -> None:
    assert abs(safe(speed_share=0.5)(state(V_E=6.0))[0]) < 1e-9
    assert safe(accel=0.7)(state(V_E=2.0)) == 0.7


def test_smooth_levels_stay_within_the_change() -> None:
    wanted, accel = np.array([2.0, -3.0, -3.0, -9.0]), np.array([0.0, 0.0, -1.6, 0.0])
    chosen = LEVELS[smooth_levels(LEVELS, wanted, accel, 1.6, 6.0)]
    np.testing.assert_array_equal(chosen, [1.0, -1.5, -3.0, -6.0])


def test_smooth_levels_take_the_nearest_where_none_is_within_the_change() -> None:
    assert LEVELS[smooth_levels(LEVELS, np.array([2.0]), np.array([-4.0]), 0.5, 6.0)] == -3.0


def test_without_bounds_smooth_levels_are_the_nearest_ones() -> None:
    wanted, accel = np.linspace(-8.0, 3.0, 50), np.linspace(2.0, -6.0, 50)
    chosen = smooth_levels(LEVELS, wanted, accel, np.inf, np.inf)
    np.testing.assert_array_equal(chosen, nearest_levels(LEVELS, wanted))
