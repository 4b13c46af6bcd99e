"""Braking distances as Python may ask for them: they are made to be parts of kernels."""

from hhrl_envs import dynamics
from hhrl_envs.compiled import Floats, kernel


@kernel
def braking_distance(speed: float, c: Floats) -> float:
    return dynamics.braking_distance(speed, c)


@kernel
def longest_braking(speed: float, c: Floats) -> float:
    return dynamics.longest_braking(speed, c)
