"""A bad value of a scenario or of its parts is one line that names the field, the value and what to write instead."""

from collections.abc import Callable
from dataclasses import fields, replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from hhrl_envs import (
    SCENARIOS,
    Adversary,
    Band,
    Ghosts,
    Goal,
    InputError,
    Road,
    Scenario,
    Signal,
    Slippery,
    Vehicle,
    get_scenario,
)
from hhrl_envs.simulation.constants import pack
from hhrl_envs.views.arguments import as_flag
from hhrl_envs.views.parallel_env import StopLineParallelEnv

MAIN = get_scenario("stop-line-v0")
FAMILY = MAIN.traffic.families[0]
NAN, INF = float("nan"), float("inf")
PARTS = ("traffic", "vehicle", "road", "sensor", "reward", "band")
WHOLE: dict[str, Any] = {
    part.__class__.__name__: part
    for part in (
        MAIN, MAIN.traffic, MAIN.vehicle, MAIN.road, MAIN.sensor, MAIN.reward, MAIN.band, FAMILY, Signal((5.0, 30.0)),
        Adversary(), Slippery(0.5, (0.1, 0.3)), Ghosts(0.5),
    )
}  # fmt: skip

BAD: dict[str, dict[str, list[Any]]] = {
    "Scenario": {
        "id": ["", "a\nb", "a b", " a", None, 3, "a/b"],
        "goal": [7, 0, None, "stop", "STOP"],
        "horizon": [INF, NAN, 60.5, 60.0, "60", 0, True, None, 40_001, 2**70],
        "dt": ["0.1", 0.0, 1.5, NAN, 5e-324, None, True],
        "signal": [(5, 30), 5.0, True, "green"],
        "adversary": [True, 1.0, "yes"],
        "learned_fronts": [1.5, "1", 1.0, True, -1, 5, NAN],
        "feasible_only": ["no", 0, None, 1.0],
        "route_end": [0.0, 1e-9, INF, "40", None, True],
        **{
            part: [None, "default", {}, 1, Vehicle]
            for part in ("traffic", "vehicle", "road", "sensor", "reward", "band")
        },
    },
    "Traffic": {
        "families": [FAMILY, ("calm",), (), [FAMILY], None, "calm", (FAMILY, None)],
        "count_shares": [1.0, (), (0.5, 0.4), (NAN, 1.0), (-0.5, 1.5), "1", ("1",), [1.0], (True,), None, (0.0,) * 200],
        "gap": [(8, INF), 8.0, (8.0,), (8.0, 9.0, 10.0), "8-25", (NAN, 9.0), (9.0, 8.0), (0.5, 2.0), ("8", "9"), None],
        "speed": [(5, INF), 5.0, (5.0, NAN), (-1.0, 5.0), [5.0, 6.0], (False, True)],
    },
    "Road": {
        "lines": [0.0, ("a",), [0.0], None, (NAN,), (INF,), (0.0, 0.0), (5.0, 1.0), (0.0, 1.0, 2.0), (-1.0,), (True,)],
        "start_distance": [60.0, (50.0,), (80.0, 60.0), (55.0, INF), (55.0, 501.0), (NAN, 60.0), None, "55"],
        "start_speed": [5.0, (5.0, INF), (5.0, NAN), (5.0, 6.0, 7.0), (-1.0, 5.0)],
        "speed_limit": [0.0, 1e-300, "12", INF, NAN, None, True],
        "stop_zone": [-1.0, 0.0, 5e-324, "2", INF, NAN],
        "stop_speed": [0.0, 1e-12, "0.1", INF, NAN],
        "friction": [0.0, 1e-9, 0.009, 1.6, "dry", NAN, True],
        "slippery": [0.5, (0.1, 0.3), True, {}, "ice", Slippery],
    },
    "Slippery": {
        "share": [-0.1, 1.1, NAN, "0.5", True, None],
        "friction": [0.2, (0.2,), (0.3, 0.2), (0.009, 0.2), (0.2, 1.6), (NAN, 0.3), [0.1, 0.2], None, "ice"],
    },
    "Vehicle": {
        "levels": [
            3.0,
            (1.0,),
            (2.0, -3.0),
            (1.0, 2.0),
            (-2.0, -1.0),
            (-1e-9, 2.0),
            (-3.0, 0.09),
            [-3.0, 2.0],
            (-INF, 2.0),
            (-1.0, NAN),
            None,
            "ab",
        ],
        "lag": [-0.1, "0.3", INF, NAN, True, None],
        "jerk_limit": [0.0, 1e-12, "15", INF, NAN],
        "max_decel": [0.0, 1e-320, NAN, INF, None],
        "length": [0.0, 1e-9, INF, (5.0,)],
    },
    "Sensor": {
        "delay": [1.5, 1.0, -1, 51, "1", True, None, NAN],
        "front_range": [0.0, NAN, INF, "100"],
        "line_range": [0.0, 1001.0, None],
        "noise_distance": [-0.5, NAN, INF, "3"],
        "noise_speed": [-0.5, None],
        "noise_accel": [-0.5, False],
        "dropout": [-0.1, 0.951, 1, NAN, "0.5", True, None],
        "dropout_time": [0.0, 1e-9, 1001.0, INF, NAN, "1", None],
        "ghosts": [0.5, True, {}, "some", Ghosts, (0.5, 40.0, 6.0)],
    },
    "Ghosts": {
        "share": [-0.1, 1.1, NAN, "0.5", True, None],
        "stretch": [0.0, 9.9, 1001.0, INF, "40", None],
        "near": [0.0, -1.0, 1001.0, NAN, True, None],
    },
    "Reward": {
        "sigma_1": [-1.0, NAN],
        "sigma_2": [INF, None],
        "sigma_3": ["36", True],
        "sigma_4": [(49.0,), -0.1],
        "jerk_threshold": [INF, "4"],
        "positive_jerk_only": ["no", 1, None],
        "safe_gap": [0.0, 1e-9, NAN, "5"],
        "timeout_scale": [-1.0, INF, True],
        "unsafe": ["literal", "Printed", "", None, True, 1.0, ("printed",), ["printed"]],
    },
    "Signal": {"green_at": [5.0, (INF, INF), (5.0, 1.0), (5.0, 6.0, 7.0), "5", None, (NAN, NAN), (-1.0, 5.0)]},
    "Band": {
        "low": [-1.0, 10.0, "2", NAN],
        "high": [2.0, INF, True],
        "headway": [-1.0, NAN, "3"],
        "share": [0.0, 5e-324, 1.1, NAN, "0.8"],
    },
    "Adversary": {"hardest_brake": [0.0, 1e-9, INF, NAN, "4.5", True], "patience": [-1.0, INF, NAN, None]},
    "ProfileFamily": {
        "name": [None, "", " ", "a\nb", 3],
        "weight": [0.0, 1e-300, INF, NAN, "1", True, None],
        "slow_chance": [1.5, NAN, "0.5", True],
        "styles": [(0.5, 0.5), (NAN, 0.5, 0.5), None, (0.5, 0.2, 0.1), "abc", [1.0, 0.0, 0.0], (1.5, -0.5, 0.0), 1.0],
        "headway": [2.0, (2.0, 1.0), (1.0, 2.0, 3.0), "12", (1.0, INF), (NAN, 2.0), None, (False, True)],
        "stop_position": [(100, 100), (-5.0, 0.0), (0.0, INF)],
        "max_accel": [(0.0, 1.0), (1e-9, 1.0), (1.0, INF)],
        "dwell": [(0.0, INF), 1.0],
    },
}
ENDLESS = [
    ("Vehicle", "levels", (-1e-9, 2.0), "levels from a brake of -0.1 or below to a throttle of 0.1 or above"),
    ("Vehicle", "jerk_limit", 1e-12, "m/s^3 from 0.1 to 1000000"),
    ("Vehicle", "max_decel", 1e-320, "m/s^2 from 0.1 to 100"),
    ("Road", "friction", 1e-9, "a coefficient from 0.01 to 1.5"),
    ("Scenario", "horizon", 10**6, "an integer from 1 to 20000 (steps)"),
]  # once they kept a loop from ending, or gave a NaN
CASES = [(part, field, value) for part, bad in BAD.items() for field, values in bad.items() for value in values]


def refused(call: Callable[[], object], *said: str) -> None:
    with pytest.raises(InputError) as caught:
        call()
    message = str(caught.value)
    assert "\n" not in message
    assert len(message) < 320
    for words in said:
        assert words in message


@pytest.mark.parametrize(("part", "field", "value"), CASES, ids=lambda value: repr(value)[:30])
def test_a_bad_value_is_refused_by_its_name(part: str, field: str, value: Any) -> None:
    given = value.name if isinstance(value, Goal) else repr(value)[:60]
    refused(partial(replace, WHOLE[part], **{field: value}), f"{field} is {given}", "; write ")


@pytest.mark.parametrize(("part", "field", "value", "write"), ENDLESS)
def test_what_no_world_ends_with_is_refused_in_one_line(part: str, field: str, value: Any, write: str) -> None:
    with pytest.raises(InputError) as caught:
        replace(WHOLE[part], **{field: value})
    assert str(caught.value) == f"{part}.{field} is {value!r}; write {write}"


@pytest.mark.parametrize(
    ("part", "field"), [(part, field.name) for part in WHOLE for field in fields(WHOLE[part])], ids=str
)
def test_every_field_has_a_rule(part: str, field: str) -> None:
    for value in (object, NAN, ((),), {"low": 1.0}, np.array([1.0, 2.0])):
        refused(partial(replace, WHOLE[part], **{field: value}), f"{field} is ", "; write ")


def test_arguments_in_the_wrong_order() -> None:
    refused(lambda: Scenario(MAIN.traffic, "x"), "Scenario.id is Traffic(", "; write a name")  # type: ignore[arg-type]


def test_a_family_is_named() -> None:
    said = "profile family 'calm': headway is 2.0; write a tuple (low, high) in s"
    refused(lambda: replace(FAMILY, headway=2.0), said)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: Road(stop_zone=100), ("start_distance is (55.0, 85.0)", "stop_zone is 100")),
        (lambda: Road(speed_limit=8.3), ("start_speed is (5.0, 10.0)", "speed_limit is 8.3")),
        (lambda: Road(start_speed=(5.0, 50.0)), ("start_speed is (5.0, 50.0)", "speed_limit is 12.0")),
        (lambda: Band(low=10.0), ("low is 10.0", "high is 10.0")),
        (lambda: replace(MAIN, road=Road(lines=())), ("road.lines is ()", "goal is Goal.STOP")),
        (lambda: replace(MAIN, signal=Signal((1, 2))), ("signal is Signal(", "goal is Goal.STOP", "goal PASS")),
        (lambda: replace(MAIN, horizon=50), ("horizon is 50 and dt is 0.1", "write a horizon of 86 steps or more")),
        (lambda: replace(MAIN, dt=1.0, horizon=3601), ("horizon is 3601 and dt is 1.0", "at most 3600 steps")),
        (lambda: replace(MAIN, dt=0.01), ("horizon is 600 and dt is 0.01", "write a horizon of 858 steps or more")),
    ],
    ids=["stop_zone", "speed_limit", "start_speed", "band", "lines", "signal", "horizon", "hours", "dt"],
)
def test_fields_that_disagree_are_all_named(call: Callable[[], object], said: tuple[str, ...]) -> None:
    refused(call, *said)


def test_scenarios_without_a_place_for_learned_fronts_say_why() -> None:
    said = "learned_fronts is 1; write 0 for scenario "
    refused(lambda: replace(SCENARIOS["follow-v0"], learned_fronts=1), said, "goal FOLLOW")
    refused(lambda: replace(SCENARIOS["solo-stop-v0"], learned_fronts=1), said, "no front vehicles")


def test_agents_keep_to_the_speed_limit_from_the_start() -> None:
    swift = replace(MAIN, traffic=replace(MAIN.traffic, speed=(5.0, 30.0)))
    said = "Scenario.traffic.speed is (5.0, 30.0) and road.speed_limit is 12.0; write a traffic.speed of at most"
    refused(lambda: replace(swift, learned_fronts=1), said)
    refused(lambda: StopLineParallelEnv(swift, learned_fronts=1), said)


def test_short_time_limits_are_allowed_where_a_world_may_be_infeasible_or_nobody_queues() -> None:
    assert replace(MAIN, horizon=86).horizon == 86
    assert replace(MAIN, horizon=7, feasible_only=False).horizon == 7
    assert replace(SCENARIOS["follow-v0"], horizon=50).horizon == 50


def test_numbers_of_numpy_are_numbers() -> None:
    numbers: dict[str, Any] = {"horizon": np.int64(600), "feasible_only": np.bool_(True), "dt": np.float64(0.1)}
    start: Any = (np.int64(5), np.float32(10.0))
    given = replace(MAIN, road=Road(start_speed=start, lines=(np.float64(0.0),)), **numbers)
    plain = replace(MAIN, road=Road(start_speed=(5, 10.0)))
    assert given == plain
    assert given.spec_hash == plain.spec_hash
    assert pack(given).tobytes() == pack(plain).tobytes()
    narrow: Any = np.float16(0.1)
    assert type(replace(MAIN, dt=narrow).dt) is float
    infinite: Any = np.float16("inf")
    refused(lambda: Vehicle(lag=infinite), "lag is ")


def test_state_before_reset() -> None:
    env = StopLineParallelEnv()
    refused(env.state, "state before reset; call reset(seed=...) first")
    env.reset(seed=1)
    assert env.state().shape == (11,)


@pytest.mark.parametrize("value", ["no", 0, None, 1.0, []], ids=repr)
def test_flags(value: Any) -> None:
    refused(partial(as_flag, value, "continuous_actions"), f"continuous_actions is {value!r}; write True or False")
    assert as_flag(np.True_, "continuous_actions") is True  # type: ignore[arg-type]
    assert not as_flag(False, "continuous_actions")
