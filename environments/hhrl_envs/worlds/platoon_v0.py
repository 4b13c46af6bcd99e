"""Learned front vehicles: three of them and the ego must stop at the line in turn."""

from dataclasses import replace

from hhrl_envs.scenario.scenario import Traffic
from hhrl_envs.views.triad import register
from hhrl_envs.worlds.driver_families import TRAIN_FAMILIES
from hhrl_envs.worlds.stop_line_v0 import SCENARIO as STOP_LINE

SCENARIO = replace(
    STOP_LINE,
    id="platoon-v0",
    traffic=Traffic(families=TRAIN_FAMILIES, count_shares=(0, 0, 0, 0.6, 0.4), gap=(10.0, 25.0)),
    horizon=1200,
    feasible_only=False,
    learned_fronts=3,
)

env, raw_env, parallel_env = register(
    SCENARIO,
    place=13,
    summary="the three nearest front vehicles are agents too: all have to stop in turn",
)
