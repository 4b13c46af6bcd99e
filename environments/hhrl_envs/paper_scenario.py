"""The world of the paper's Table I, as far as its Rules 1 to 4 tell.

The paper prints the task and the results, not the distributions behind them. These numbers were fitted, by

    hhrl-bench calibrate --seed 0 --generations 70

to all nine columns of the four rules; ``hhrl_bench.calibration_space`` says what was free and within which ranges, and
``leaderboards/calibration`` what is left of the differences. The reward constants are those that Table I implies.
"""

from dataclasses import replace

from hhrl_envs.profiles import ProfileFamily
from hhrl_envs.scenario import Reward, Road, Scenario, Traffic, Vehicle

_ORDINARY = ProfileFamily(
    "ordinary",
    0.61,
    desired_speed=(11.5, 13.0),
    max_accel=(2.8, 3.3),
    dwell=(5.4, 7.1),
)
_ABRUPT = replace(_ORDINARY, name="abrupt", weight=0.19, line_decel=(6.7, 7.7), stop_position=(1.0, 7.0))
_PAST_THE_LINE = replace(_ORDINARY, name="past-the-line", weight=0.2, stop_position=(-4.0, -0.5))

STOP_LINE_PAPER = Scenario(
    id="stop-line-paper-v0",
    traffic=Traffic(
        families=(_ORDINARY, _ABRUPT, _PAST_THE_LINE),
        count_shares=(0.13, 0.44, 0.43),
        gap=(9.0, 11.5),
        speed=(9.5, 10.5),
    ),
    vehicle=Vehicle(lag=1.3, jerk_limit=6.0, max_decel=5.7),
    road=Road(speed_limit=13.0, start_distance=(27.0, 32.0), start_speed=(7.5, 9.0)),
    reward=Reward(jerk_threshold=24.1, safe_gap=1.3),
)
"""Rules 1 to 4 collide here, run the line and succeed as often as in Table I."""
