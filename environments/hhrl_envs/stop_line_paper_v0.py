"""PettingZoo's stop-line-paper-v0."""

from hhrl_envs.triads import triad

env, raw_env, parallel_env = triad("stop-line-paper-v0")
