from dataclasses import replace

import numpy as np
import pytest

from hhrl_envs import InputError, Road, Signal, Simulator, Traffic, get_scenario
from hhrl_envs.simulation.survey import feasible_share

MAIN = get_scenario("stop-line-v0")
CLOSE = replace(
    MAIN,
    traffic=Traffic(families=MAIN.traffic.families, count_shares=(0.5, 0.5), gap=(1.0, 9.0), speed=(0.0, 6.0)),
    road=Road(start_speed=(8.0, 12.0)),
)


def test_rejected_worlds_count() -> None:
    share = feasible_share(CLOSE, 500)
    assert 0.5 < share < 0.9
    simulator = Simulator(CLOSE, 500)
    simulator.reset(np.arange(500))
    assert simulator.feasible.all()


def test_a_road_without_traffic_is_always_feasible() -> None:
    assert feasible_share(get_scenario("solo-stop-v0"), 200) == feasible_share("solo-stop-v0", 200) == 1.0
    with pytest.raises(InputError, match="worlds is 0; write an integer, at least 1"):
        feasible_share("solo-stop-v0", 0)


def test_who_cannot_stop_before_the_line_cannot_succeed() -> None:
    ice = replace(MAIN, road=Road(friction=0.01, start_speed=(8.0, 10.0)))
    assert feasible_share(ice, 200) == 0.0


def test_a_light_that_stays_red_leaves_no_time() -> None:
    red = get_scenario("red-light-v0")
    assert feasible_share(replace(red, signal=Signal((100.0, 100.0))), 200) == 0.0
