"""PettingZoo's solo-stop-v0."""

from hhrl_envs.triads import triad

env, raw_env, parallel_env = triad("solo-stop-v0")
