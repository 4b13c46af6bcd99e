"""The sub-goal FFV alone: follow the front vehicle within a band until the horizon; there is no line."""

from dataclasses import replace

from hhrl_envs.scenario.scenario import Goal, Road, Traffic
from hhrl_envs.views.triad import register
from hhrl_envs.worlds.driver_families import STOP_AND_GO_FAMILIES, TRAIN_FAMILIES
from hhrl_envs.worlds.stop_line_v0 import SCENARIO as STOP_LINE

SCENARIO = replace(
    STOP_LINE,
    id="follow-v0",
    traffic=Traffic(families=STOP_AND_GO_FAMILIES + TRAIN_FAMILIES[:2], count_shares=(0, 0.4, 0.4, 0.2)),
    road=Road(lines=()),
    goal=Goal.FOLLOW,
    horizon=400,
)

env, raw_env, parallel_env = register(
    SCENARIO,
    place=8,
    summary="keep a gap of 2 m to 10 m + 3 s v_f in 80% of the steps",
)
