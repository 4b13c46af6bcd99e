"""PettingZoo's platoon-v0."""

from hhrl_envs.triads import triad

env, raw_env, parallel_env = triad("platoon-v0")
