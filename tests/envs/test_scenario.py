from dataclasses import replace
from typing import Any

import pytest

from hhrl_envs import (
    SCENARIOS,
    Band,
    Goal,
    InputError,
    Reward,
    Road,
    Scenario,
    Sensor,
    Signal,
    Traffic,
    UnknownScenarioError,
    Vehicle,
    get_scenario,
)
from hhrl_envs.profiles import TRAIN_FAMILIES, ProfileFamily

MAIN = get_scenario("stop-line-v0")


def test_an_unknown_id_lists_the_known_ones_in_one_line() -> None:
    with pytest.raises(UnknownScenarioError, match="stop-line-v0") as caught:
        get_scenario("stop-line-v9")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("scenario", SCENARIOS.values(), ids=str)
def test_a_registered_scenario_is_hashable_versioned_data(scenario: Scenario) -> None:
    assert hash(scenario) == hash(replace(scenario))
    assert scenario.id.rsplit("-", 1)[1].startswith("v")
    assert len(scenario.spec_hash) == 64


def test_hashes_follow_what_they_stand_for() -> None:
    other_world = replace(MAIN, horizon=500)
    assert other_world.spec_hash != MAIN.spec_hash
    assert other_world.interface_hash == MAIN.interface_hash
    other_levels = replace(MAIN, vehicle=Vehicle(levels=(-3.0, 2.0)))
    assert other_levels.interface_hash != MAIN.interface_hash


@pytest.mark.parametrize(
    ("part", "field", "value"),
    [
        (Vehicle, "levels", (1.0,)),
        (Vehicle, "levels", (2.0, -3.0)),
        (Vehicle, "levels", (1.0, 2.0)),
        (Vehicle, "lag", -0.1),
        (Vehicle, "jerk_limit", 0.0),
        (Vehicle, "max_decel", float("nan")),
        (Vehicle, "length", float("inf")),
        (Road, "speed_limit", 0.0),
        (Road, "stop_zone", -1.0),
        (Road, "stop_speed", 0.0),
        (Sensor, "front_range", float("nan")),
        (Road, "start_distance", (80.0, 60.0)),
        (Road, "start_speed", (5.0, 50.0)),
        (Road, "lines", (0.0, 10.0, 20.0)),
        (Road, "lines", (5.0, 1.0)),
        (Road, "friction", 0.0),
        (Sensor, "delay", -1),
        (Sensor, "noise_speed", -0.5),
        (Signal, "green_at", (5.0, 1.0)),
        (Band, "share", 0.0),
        (Reward, "sigma_2", -1.0),
        (Reward, "safe_gap", 0.0),
    ],
)
def test_a_bad_value_is_named(part: Any, field: str, value: object) -> None:
    with pytest.raises(InputError, match=field) as caught:
        part(**{field: value})
    assert "write" in str(caught.value)


@pytest.mark.parametrize(
    ("field", "value"),
    [("count_shares", (0.5, 0.4)), ("count_shares", ()), ("families", ()), ("gap", (0.0, 3.0)), ("speed", (5.0, 1.0))],
)
def test_bad_traffic_is_named(field: str, value: Any) -> None:
    with pytest.raises(InputError, match=field):
        replace(Traffic(families=TRAIN_FAMILIES), **{field: value})


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("weight", 0.0),
        ("styles", (0.5, 0.2, 0.1)),
        ("slow_chance", 1.5),
        ("headway", (2.0, 1.0)),
        ("max_accel", (0.0, 1.0)),
        ("dwell", (0.0, float("inf"))),
    ],
)
def test_a_bad_profile_family_is_named(field: str, value: Any) -> None:
    with pytest.raises(InputError, match=field):
        replace(ProfileFamily("odd", 1.0), **{field: value})


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"road": Road(lines=())}, "lines"),
        ({"goal": Goal.FOLLOW}, "lines"),
        ({"goal": Goal.FOLLOW, "road": Road(lines=())}, "count_shares"),
        ({"signal": Signal((1.0, 2.0))}, "signal"),
        ({"dt": 0.0}, "dt"),
        ({"horizon": 0}, "horizon"),
    ],
)
def test_contradictions_are_named(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        replace(MAIN, **changes)
