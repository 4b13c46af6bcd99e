"""The main task among drivers of families that no training scenario draws from."""

from dataclasses import replace

from hhrl_envs.scenario.scenario import Traffic
from hhrl_envs.views.triad import register
from hhrl_envs.worlds.driver_families import HELD_OUT_FAMILIES
from hhrl_envs.worlds.stop_line_v0 import SCENARIO as STOP_LINE

SCENARIO = replace(STOP_LINE, id="stop-line-heldout-v0", traffic=Traffic(families=HELD_OUT_FAMILIES))

env, raw_env, parallel_env = register(SCENARIO, place=3, summary="drivers of the held-out families")
