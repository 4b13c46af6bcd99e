"""A traffic jam before the line: every front vehicle brakes and drives on again and again."""

from dataclasses import replace

from hhrl_envs.scenario.scenario import Traffic
from hhrl_envs.views.triad import register
from hhrl_envs.worlds.driver_families import STOP_AND_GO_FAMILIES
from hhrl_envs.worlds.stop_line_v0 import SCENARIO as STOP_LINE

SCENARIO = replace(
    STOP_LINE,
    id="stop-and-go-v0",
    traffic=Traffic(families=STOP_AND_GO_FAMILIES, count_shares=(0, 0.3, 0.4, 0.3)),
    horizon=900,
)

env, raw_env, parallel_env = register(SCENARIO, place=11, summary="a jam on the way")
