"""A harder tier: poor sensors: errors of 4 m, 0.5 m/s and 0.5 m/s^2 (standard deviations), 0.9 s late, 30 m of sight.

One reading of the distance is less exact than the stop zone is long, as with satellite positioning between houses. All
of them are old, as a human driver's reaction is (Green 2000: 0.7 s and more). Hidden is where the line and the front
vehicle are now. Who answers readings as if they were true and new swings around the planned speed and runs over the
line; who averages them by inertia is late. An agent with memory can filter the readings over time and predict the
present from its own actions. Revealed, the same rule comes close to the oracle.
"""

from dataclasses import replace

from hhrl_envs.views.triad import register
from hhrl_envs.worlds.stop_line_noisy_v0 import SCENARIO as EARLIER

SCENARIO = replace(EARLIER, id="stop-line-noisy-v1", sensor=replace(EARLIER.sensor, noise_distance=4.0))

env, raw_env, parallel_env = register(
    SCENARIO,
    place=7,
    summary="sensors with errors of 4 m, 0.5 m/s and 0.5 m/s^2, 0.9 s late, that see vehicles within 30 m",
)
