"""PettingZoo's red-light-v0."""

from hhrl_envs.triads import triad

env, raw_env, parallel_env = triad("red-light-v0")
