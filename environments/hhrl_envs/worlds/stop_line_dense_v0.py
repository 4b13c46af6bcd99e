"""Superseded by stop-line-dense-v1: a long queue whose tail is out of sight.

Traffic arrives with time gaps of 1.4 to 3.8 s, the line lets one vehicle pass in several seconds: three to six vehicles
pile up. A front vehicle shows at 16 m only, as in dense fog or behind a bend, and 0.6 s late. Nothing in sight
does not mean an empty road, so the answer is the assured clear distance: so slow that one can stop within sight (German
road law allows 50 km/h at most where sight is below 50 m, StVO 3(1)). Who takes nothing seen for nothing there drives
into the tail. It asks for another reaction to d_f at its limit, not for memory.
"""

from dataclasses import replace

from hhrl_envs.scenario.scenario import Road, Scenario, Traffic
from hhrl_envs.scenario.sensors import Sensor
from hhrl_envs.views.triad import register
from hhrl_envs.worlds.driver_families import TRAIN_FAMILIES

_COMMUTERS = tuple(replace(family, desired_speed=(12.8, 16.0), max_accel=(1.5, 2.6)) for family in TRAIN_FAMILIES)

SCENARIO = Scenario(
    id="stop-line-dense-v0",
    traffic=Traffic(
        families=_COMMUTERS, count_shares=(0, 0, 0, 0.2, 0.3, 0.3, 0.2), gap=(20.0, 40.0), speed=(10.4, 14.4)
    ),
    road=Road(speed_limit=16.0, start_distance=(200.0, 280.0), start_speed=(9.6, 12.8)),
    sensor=Sensor(front_range=16.0, delay=6),
    horizon=900,
    feasible_only=False,
)

env, raw_env, parallel_env = register(
    SCENARIO,
    place=15,
    summary="a long queue whose tail is out of sight",
    superseded_by="stop-line-dense-v1",
)
