"""The main task: stop at the stop-line behind traffic of the train families."""

from hhrl_envs.scenario.scenario import Scenario, Traffic
from hhrl_envs.views.triad import register
from hhrl_envs.worlds.driver_families import TRAIN_FAMILIES

SCENARIO = Scenario(id="stop-line-v0", traffic=Traffic(families=TRAIN_FAMILIES))

env, raw_env, parallel_env = register(SCENARIO, place=1, summary="the main task")
