"""Superseded by stop-line-noisy-v1: errors of 3 m, 0.5 m/s and 0.5 m/s^2 (standard deviations), 0.9 s late.

One reading of the distance is less exact than the stop zone is long, as with satellite positioning between houses, and
all of them are old; sight ends at 30 m. Who answers them as if they were true and new swings around the planned speed
and runs over the line. A gentle approach, which the vehicle's inertia averages, does better without memory.
"""

from hhrl_envs.scenario.scenario import Scenario, Traffic
from hhrl_envs.scenario.sensors import Sensor
from hhrl_envs.views.triad import register
from hhrl_envs.worlds.driver_families import TRAIN_FAMILIES

SCENARIO = Scenario(
    id="stop-line-noisy-v0",
    traffic=Traffic(families=TRAIN_FAMILIES),
    sensor=Sensor(front_range=30.0, noise_distance=3.0, noise_speed=0.5, noise_accel=0.5, delay=9),
    feasible_only=False,
)

env, raw_env, parallel_env = register(
    SCENARIO,
    place=18,
    summary="sensors with errors of 3 m, 0.5 m/s and 0.5 m/s^2, 0.9 s late, that see vehicles within 30 m",
    superseded_by="stop-line-noisy-v1",
)
