"""A traffic light at the line: stop while it is red, pass once it is green."""

from dataclasses import replace

from hhrl_envs.scenario.scenario import Goal, Signal
from hhrl_envs.views.triad import register
from hhrl_envs.worlds.stop_line_v0 import SCENARIO as STOP_LINE

SCENARIO = replace(STOP_LINE, id="red-light-v0", goal=Goal.PASS, signal=Signal(green_at=(5.0, 30.0)))

env, raw_env, parallel_env = register(
    SCENARIO,
    place=10,
    summary="the line is a light that turns green after 5 to 30 s",
)
