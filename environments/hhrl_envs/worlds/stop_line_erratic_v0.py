"""Superseded by stop-line-erratic-v1: a sluggish vehicle behind drivers who brake hard without a reason.

On a 72 km/h road the fronts brake with 6 to 8 m/s^2 for 1 to 3 s, every 60 to 140 m (every few seconds). The ego's
brakes build up with a lag of 1 s, as a loaded lorry's, and 2.5 m/s^3 of jerk (what ISO 15622 allows an adaptive cruise
control), and it sees them 0.8 s late, a quick human driver's reaction. The nominal gap is that of queues, 2 m (1.5 to
3.7 m, TRID 152931). The usual headway is too short here; the answer is a longer one and early braking, not memory.
"""

from hhrl_envs.scenario.profiles import ProfileFamily
from hhrl_envs.scenario.scenario import Reward, Road, Scenario, Traffic, Vehicle
from hhrl_envs.scenario.sensors import Sensor
from hhrl_envs.views.triad import register

_DRIVERS = (
    ProfileFamily(
        "erratic",
        1.0,
        desired_speed=(16.0, 20.0),
        headway=(0.4, 1.0),
        max_accel=(2.0, 3.5),
        comfort_decel=(3.0, 6.0),
        line_decel=(3.4, 7.0),
        dwell=(0.2, 2.0),
        slow_at=(20.0, 300.0),
        slow_decel=(6.0, 8.0),
        slow_time=(1.0, 3.0),
        slow_every=(60.0, 140.0),
        slow_chance=1.0,
        styles=(0.7, 0.2, 0.1),
    ),
)

SCENARIO = Scenario(
    id="stop-line-erratic-v0",
    traffic=Traffic(families=_DRIVERS, count_shares=(0, 0.4, 0.4, 0.2), gap=(15.0, 30.0), speed=(14.0, 18.0)),
    vehicle=Vehicle(lag=1.0, jerk_limit=2.5),
    road=Road(speed_limit=20.0, start_distance=(250.0, 350.0), start_speed=(12.0, 16.0)),
    sensor=Sensor(delay=8),
    reward=Reward(safe_gap=2.0),
    horizon=800,
    feasible_only=False,
)

env, raw_env, parallel_env = register(
    SCENARIO,
    place=16,
    summary="hard braking without a reason ahead of a sluggish vehicle",
    superseded_by="stop-line-erratic-v1",
)
