"""Whatever validation accepts ends in time, within its spaces, without an overlap or a NaN; see `make fuzz`."""

import time
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from hhrl_envs import InputError, Road, Scenario, Simulator, Vehicle, get_scenario
from hhrl_envs.scenario import limits
from hhrl_envs.simulation.engine import layout as at
from support import worlds
from support.hostile import require_one_line

MAIN = get_scenario("stop-line-v0")
WEAKEST = Vehicle(
    levels=(-limits.WEAKEST, limits.WEAKEST),
    lag=limits.VEHICLE["lag"].high,
    jerk_limit=limits.VEHICLE["jerk_limit"].low,
)
ICE = replace(MAIN.road, friction=limits.ROAD["friction"].low)
FAST = Road(speed_limit=100.0, start_speed=(100.0, 100.0), start_distance=(500.0, 500.0))


@pytest.fixture(scope="module", autouse=True)
def _compiled() -> None:
    worlds.compile_kernels()


@pytest.mark.parametrize("first", range(0, 300, 50))
def test_a_world_that_validation_accepts_ends(first: int) -> None:
    ended = Counter[str]()
    for seed in range(first, first + 50):
        rng = np.random.default_rng(seed)
        try:
            worlds.run(worlds.draw_scenario(rng), rng)
            ended["ran"] += 1
        except InputError as error:
            require_one_line(str(error))
            ended["refused"] += 1
    assert min(ended.values()) > 2
    assert ended["ran"] > 20


@pytest.mark.parametrize("dt", [limits.SCENARIO["dt"].low, 0.1, limits.SCENARIO["dt"].high])
@pytest.mark.parametrize(
    "scenario",
    [
        replace(MAIN, vehicle=WEAKEST),
        replace(MAIN, road=ICE),
        replace(MAIN, vehicle=WEAKEST, road=replace(FAST, friction=ICE.friction)),
        replace(
            MAIN, vehicle=Vehicle(levels=(-100.0, 100.0), jerk_limit=1e6, lag=0.0), road=replace(FAST, friction=1.5)
        ),
    ],
    ids=["weakest", "ice", "weakest on ice", "strongest"],
)
def test_a_world_at_the_limits_ends(scenario: Scenario, dt: float) -> None:
    for seed in range(3):
        limit = replace(scenario, dt=dt, horizon=1000, feasible_only=False)
        worlds.run(limit, np.random.default_rng(seed))


def test_scripted_vehicles_keep_apart_in_the_longest_steps() -> None:
    """They come to a stand within a step, one behind the other, over and over again."""
    families = tuple(
        replace(
            family,
            slow_every=(5.0, 9.0),
            slow_decel=(9.0, 9.0),
            slow_chance=1.0,
            min_gap=(0.0, 0.0),
            headway=(0.0, 0.0),
        )
        for family in MAIN.traffic.families
    )
    traffic = replace(MAIN.traffic, families=families, count_shares=(0.0,) * 6 + (1.0,), gap=(1.0, 3.0))
    for seed in range(20):
        worlds.run(replace(MAIN, dt=1.0, traffic=traffic, feasible_only=False), np.random.default_rng(seed))


def test_slow_downs_are_found_however_far_away_a_vehicle_starts() -> None:
    families = tuple(replace(family, slow_every=(1.0, 1.5), slow_chance=1.0) for family in MAIN.traffic.families)
    traffic = replace(MAIN.traffic, families=families, count_shares=(0.0,) * 100 + (1.0,), gap=(1000.0, 1000.0))
    simulator = Simulator(replace(MAIN, traffic=traffic, feasible_only=False), 1)
    simulator.reset([0])
    fronts = simulator._vehicles(0)[1:-1]
    position, place, every = (fronts[:, at.count_fields(field)] for field in (at.POSITION, at.NEXT_SLOW, at.SLOW_EVERY))
    assert ((position <= place) & (place < position + every + 1e-6)).all()


def test_a_search_for_a_feasible_world_ends() -> None:
    """A queue that never clears the line is known only at the time limit."""
    families = tuple(
        replace(family, dwell=(1000.0, 1000.0), styles=(1.0, 0.0, 0.0)) for family in MAIN.traffic.families
    )
    traffic = replace(MAIN.traffic, families=families, count_shares=(0.0, 0.0, 0.0, 1.0))
    simulator = Simulator(replace(MAIN, traffic=traffic, dt=0.01, horizon=20_000), 1)
    begun = time.thread_time()
    with pytest.raises(InputError, match="draws no feasible world"):
        simulator.reset([0])
    assert time.thread_time() - begun < worlds.SECONDS
