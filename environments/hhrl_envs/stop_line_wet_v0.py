"""PettingZoo's stop-line-wet-v0."""

from hhrl_envs.triads import triad

env, raw_env, parallel_env = triad("stop-line-wet-v0")
