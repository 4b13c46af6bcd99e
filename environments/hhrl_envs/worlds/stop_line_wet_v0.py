"""Superseded by stop-line-wet-v1: wet ice: nobody brakes with more than 1.6 m/s^2.

A friction of 0.16 is a quarter of what the nominal a_max of 6 m/s^2 needs, with which the state's safety distances are
computed, and less than the comfortable 2 m/s^2 that planners brake with; everybody drives 5 to 9 m/s for it. Who plans
the usual stop slides over the line. The answer is to brake earlier and more softly; no memory is needed.
"""

from hhrl_envs.scenario.scenario import Road, Scenario, Traffic
from hhrl_envs.views.triad import register
from hhrl_envs.worlds.driver_families import TRAIN_FAMILIES

SCENARIO = Scenario(
    id="stop-line-wet-v0",
    traffic=Traffic(families=TRAIN_FAMILIES, gap=(18.0, 32.0), speed=(5.0, 9.0)),
    road=Road(friction=0.16, start_distance=(60.0, 90.0), start_speed=(5.0, 9.0)),
    feasible_only=False,
)

env, raw_env, parallel_env = register(
    SCENARIO,
    place=17,
    summary="wet ice: a grip of 0.16 g",
    superseded_by="stop-line-wet-v1",
)
