"""A learned front vehicle that tries to make the ego fail, within what a human driver might do."""

from dataclasses import replace

from hhrl_envs.scenario.scenario import Adversary, Traffic
from hhrl_envs.views.triad import register
from hhrl_envs.worlds.driver_families import TRAIN_FAMILIES
from hhrl_envs.worlds.stop_line_v0 import SCENARIO as STOP_LINE

SCENARIO = replace(
    STOP_LINE,
    id="adversary-v0",
    traffic=Traffic(families=TRAIN_FAMILIES, count_shares=(0, 0.5, 0.3, 0.2), gap=(12.0, 25.0)),
    feasible_only=False,
    learned_fronts=1,
    adversary=Adversary(),
)

env, raw_env, parallel_env = register(
    SCENARIO,
    place=14,
    summary="the nearest front vehicle is an agent that tries to make the ego fail",
)
