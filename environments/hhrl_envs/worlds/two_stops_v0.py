"""Two stop-lines 60 m apart: stop at the first, drive on, stop at the second."""

from dataclasses import replace

from hhrl_envs.scenario.scenario import Road, Traffic
from hhrl_envs.views.triad import register
from hhrl_envs.worlds.driver_families import TRAIN_FAMILIES
from hhrl_envs.worlds.stop_line_v0 import SCENARIO as STOP_LINE

_CAUTIOUS = tuple(replace(family, line_decel=(1.2, 2.2), styles=(1.0, 0.0, 0.0)) for family in TRAIN_FAMILIES[:2])

SCENARIO = replace(
    STOP_LINE,
    id="two-stops-v0",
    traffic=Traffic(families=_CAUTIOUS, count_shares=(0.2, 0.4, 0.4)),
    road=Road(lines=(0.0, 60.0)),
    horizon=1200,
)

env, raw_env, parallel_env = register(SCENARIO, place=12, summary="the second line is 60 m behind the first")
