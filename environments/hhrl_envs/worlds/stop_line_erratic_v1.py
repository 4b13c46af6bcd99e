"""A harder tier: drivers who stop without a reason, and a radar that reports standing vehicles where there are none.

The fronts brake with 3.5 to 6 m/s^2 for 0.5 to 2 s, every 30 to 80 m. Four stretches of 30 m out of five have a ghost:
what a radar makes of a bridge, a sign or a manhole cover, and what cars have braked for without a reason (NHTSA,
investigation PE22-002). It is gone when it is 6 m away, below the beam. Hidden is whether what stands ahead is there.
An observation does not tell: with these drivers a front vehicle that stands is nothing unusual. Who remembers the front
vehicle of a moment ago knows, for nobody can have come between. Revealed, without the ghosts, the same rule comes close
to the oracle.
"""

from hhrl_envs.scenario.profiles import ProfileFamily
from hhrl_envs.scenario.scenario import Road, Scenario, Traffic
from hhrl_envs.scenario.sensors import Ghosts, Sensor
from hhrl_envs.views.triad import register

_DRIVERS = (
    ProfileFamily(
        "erratic",
        1.0,
        desired_speed=(10.0, 14.0),
        headway=(0.6, 1.2),
        max_accel=(2.0, 3.5),
        comfort_decel=(3.0, 6.0),
        line_decel=(3.4, 7.0),
        dwell=(0.2, 2.0),
        slow_at=(20.0, 300.0),
        slow_decel=(3.5, 6.0),
        slow_time=(0.5, 2.0),
        slow_every=(30.0, 80.0),
        slow_chance=1.0,
        styles=(0.7, 0.2, 0.1),
    ),
)

SCENARIO = Scenario(
    id="stop-line-erratic-v1",
    traffic=Traffic(families=_DRIVERS, count_shares=(0, 0.4, 0.4, 0.2), gap=(12.0, 25.0), speed=(9.0, 12.0)),
    road=Road(speed_limit=14.0, start_distance=(150.0, 220.0), start_speed=(8.0, 12.0)),
    sensor=Sensor(ghosts=Ghosts(share=0.8, stretch=30.0, near=6.0)),
    horizon=800,
    feasible_only=False,
)

env, raw_env, parallel_env = register(
    SCENARIO,
    place=5,
    summary="hard braking without a reason, and standing vehicles that only the sensor sees",
)
