"""The sub-goal SSL alone: stop at the line of an empty road."""

from dataclasses import replace

from hhrl_envs.scenario.scenario import Traffic
from hhrl_envs.views.triad import register
from hhrl_envs.worlds.driver_families import TRAIN_FAMILIES
from hhrl_envs.worlds.stop_line_v0 import SCENARIO as STOP_LINE

SCENARIO = replace(STOP_LINE, id="solo-stop-v0", traffic=Traffic(families=TRAIN_FAMILIES, count_shares=(1.0,)))

env, raw_env, parallel_env = register(SCENARIO, place=9, summary="nobody else on the road")
