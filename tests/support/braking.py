"""Braking distances as Python may ask for them: they are made to be parts of kernels."""

from hhrl_envs.arrays import Floats
from hhrl_envs.simulation import dynamics
from hhrl_envs.simulation.engine.compilation import kernel


@kernel
def braking_distance(speed: float, grip: float, c: Floats) -> float:
    return dynamics.braking_distance(speed, grip, c)


@kernel
def longest_braking(speed: float, grip: float, c: Floats) -> float:
    return dynamics.longest_braking(speed, grip, c)
