"""Analytic action-level policies, one for each sub-goal; both think in SI units and act through the discrete levels."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hhrl_envs import Scenario
from hhrl_envs import observation as obs
from hhrl_envs.arrays import Floats, Ints

Controller = Callable[[Floats], Floats]

COMFORT = 2.0
"""Deceleration that a controller plans with [m/s^2]."""
RESPONSE = 0.5
"""Time in which a controller removes a speed error [s]."""
HEADWAY = 1.0
"""Time gap of the follower [s]: short, for in the paper's Table I the rule that always follows collides in 18%."""


def nearest_levels(levels: Floats, accelerations: Floats) -> Ints:
    """Return the index of the level nearest to each acceleration, the lower one on a tie.

    levels: ascending target accelerations, [A] [m/s^2]; accelerations: [B] [m/s^2].
    """
    midpoints = (levels[1:] + levels[:-1]) / 2
    return np.searchsorted(midpoints, accelerations, side="left").astype(np.int64)


@dataclass(frozen=True)
class StopAtStopLine:
    """Stop in the middle of the stop zone, along the speed profile of constant comfortable braking (SSL).

    The reference speed is v(x) = sqrt(2 b x) with x the way left to the aim. It is positive everywhere before the stop
    zone, so a vehicle that stands too early moves up instead of waiting or creeping.
    """

    aim: float
    speed_limit: float
    lag: float

    @classmethod
    def for_scenario(cls, scenario: Scenario) -> "StopAtStopLine":
        """Return the controller that stops in the scenario's stop zone with its vehicle."""
        return cls(scenario.road.stop_zone / 2, scenario.road.speed_limit, scenario.vehicle.lag)

    def __call__(self, state: Floats) -> Floats:
        """Return the wanted acceleration [B] [m/s^2] for the SI state [B, 11]."""
        speed = state[:, obs.V_E]
        way = np.maximum(state[:, obs.D_D] - self.aim - self.lag * speed, 0.0)
        profile = np.sqrt(2.0 * COMFORT * way)
        braking = np.where(profile < self.speed_limit, COMFORT, 0.0)
        wanted: Floats = (np.minimum(profile, self.speed_limit) - speed) / RESPONSE - braking
        return wanted


@dataclass(frozen=True)
class FollowFrontVehicle:
    """Follow the front vehicle as the intelligent driver model does, at the speed limit when there is none (FFV).

    Source: Treiber, Hennecke, Helbing, "Congested traffic states in empirical observations and microscopic
    simulations", Phys. Rev. E 62 (2000). The standstill gap exceeds d_0 of Eq. (dis): a gap below d_0 counts as unsafe.
    """

    speed_limit: float
    standstill_gap: float
    headway: float = HEADWAY
    acceleration: float = 2.0

    @classmethod
    def for_scenario(cls, scenario: Scenario) -> "FollowFrontVehicle":
        """Return the controller that keeps more than the scenario's d_0 behind the front vehicle."""
        return cls(scenario.road.speed_limit, scenario.reward.safe_gap + 1.0)

    def __call__(self, state: Floats) -> Floats:
        """Return the wanted acceleration [B] [m/s^2] for the SI state [B, 11]."""
        speed = state[:, obs.V_E]
        closing = speed * (speed - state[:, obs.V_F]) / (2.0 * np.sqrt(self.acceleration * COMFORT))
        wanted_gap = self.standstill_gap + np.maximum(speed * self.headway + closing, 0.0)
        gap = np.maximum(state[:, obs.D_F], 0.1)
        wanted: Floats = self.acceleration * (1.0 - (speed / self.speed_limit) ** 4 - (wanted_gap / gap) ** 2)
        return wanted
