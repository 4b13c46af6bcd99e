"""PettingZoo's follow-v0."""

from hhrl_envs.triads import triad

env, raw_env, parallel_env = triad("follow-v0")
