"""PettingZoo's adversary-v0."""

from hhrl_envs.triads import triad

env, raw_env, parallel_env = triad("adversary-v0")
