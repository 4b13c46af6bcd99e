"""PettingZoo's stop-and-go-v0."""

from hhrl_envs.triads import triad

env, raw_env, parallel_env = triad("stop-and-go-v0")
