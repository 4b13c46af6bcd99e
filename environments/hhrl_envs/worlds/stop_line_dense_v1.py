"""A harder tier: a long queue in spray: the front vehicle is out of sight for two seconds at a time.

Three to six vehicles queue up before the line. In two windows of 2 s out of five the front sensor reads a free road, as
cameras and lidars do in the spray behind lorries. Hidden is whether somebody is in front. An observation without a
front vehicle does not tell; who remembers the last one that had one knows. Revealed, with the same sensor that never
drops out, the same rule comes close to the oracle.
"""

from dataclasses import replace

from hhrl_envs.scenario.scenario import Road, Scenario, Traffic
from hhrl_envs.scenario.sensors import Sensor
from hhrl_envs.views.triad import register
from hhrl_envs.worlds.driver_families import TRAIN_FAMILIES

_COMMUTERS = tuple(replace(family, desired_speed=(9.6, 13.0), max_accel=(1.5, 2.6)) for family in TRAIN_FAMILIES)

SCENARIO = Scenario(
    id="stop-line-dense-v1",
    traffic=Traffic(
        families=_COMMUTERS, count_shares=(0, 0, 0, 0.2, 0.3, 0.3, 0.2), gap=(15.0, 30.0), speed=(8.0, 12.0)
    ),
    road=Road(speed_limit=13.0, start_distance=(160.0, 240.0), start_speed=(8.0, 12.0)),
    sensor=Sensor(front_range=60.0, dropout=0.4, dropout_time=2.0),
    horizon=900,
    feasible_only=False,
)

env, raw_env, parallel_env = register(
    SCENARIO,
    place=4,
    summary="a queue of three to six, and a front sensor that drops out for 2 s at a time",
)
