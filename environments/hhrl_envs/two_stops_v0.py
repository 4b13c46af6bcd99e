"""PettingZoo's two-stops-v0."""

from hhrl_envs.triads import triad

env, raw_env, parallel_env = triad("two-stops-v0")
