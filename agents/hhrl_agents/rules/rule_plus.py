"""A stronger rule than those of Table I, to measure learned agents against."""

from dataclasses import dataclass

import numpy as np

from hhrl_agents.agent import Decision
from hhrl_agents.rules.controllers import COMFORT, nearest_levels
from hhrl_envs import Scenario
from hhrl_envs import observation as obs
from hhrl_envs.arrays import Flags, Floats, Floats32, Ints


@dataclass(frozen=True)
class Tuning:
    """How `RulePlus` drives.

    The deceleration is the comfortable one of the other rules; the rest was chosen once, for the highest mean return on
    the first 2,000 validation worlds of stop-line-v0, and the optimum is flat.

    headway: time gap to the front vehicle [s]; decel: deceleration that stops are planned with [m/s^2]; gap_margin:
    what the gap at a standstill exceeds d_0 by [m]; response: time in which a speed error is removed [s]; accel:
    acceleration of the follower [m/s^2].
    """

    headway: float = 1.5
    decel: float = COMFORT
    gap_margin: float = 1.0
    response: float = 1.0
    accel: float = 1.5


class RulePlus:
    """A hierarchical agent without memory that pursues whichever sub-goal asks for the lower acceleration.

    Both controllers act on the state one actuator lag ahead, predicted with the accelerations of ego and front vehicle:
    SSL tracks the speed profile sqrt(2 b x) towards the middle of the stop zone, FFV is the intelligent driver model.
    It knows the scenario's nominal values alone: vehicle, speed limit, stop zone and d_0.
    """

    def __init__(self, scenario: Scenario, tuning: Tuning = Tuning()) -> None:
        self._tuning = tuning
        self._mask = np.asarray(scenario.option_mask)
        self._levels = np.asarray(scenario.vehicle.levels, dtype=np.float64)
        self._lag = scenario.vehicle.lag
        self._speed_limit = scenario.road.speed_limit
        self._aim = scenario.road.stop_zone / 2
        self._standstill_gap = scenario.reward.safe_gap + tuning.gap_margin

    def reset(self, mask: Flags) -> None:
        """Return nothing: rules remember nothing."""

    def act(self, observations: Floats32) -> Decision:
        """Return the option that binds and its action, int64 [B] each; see `Agent.act`."""
        wanted = self._wanted(observations)
        option = np.where(self._mask, wanted, np.inf).argmin(axis=1).astype(np.int64)
        return Decision(option, self._pursue(wanted, option))

    def act_with_option(self, observations: Floats32, option: Ints) -> Ints:
        """Return the option's controller's actions, int64 [B]; see `HierarchicalAgent.act_with_option`."""
        return self._pursue(self._wanted(observations), option)

    def _pursue(self, wanted: Floats, option: Ints) -> Ints:
        return nearest_levels(self._levels, wanted[np.arange(len(option)), option])

    def _wanted(self, observations: Floats32) -> Floats:
        """Return the acceleration that each option asks for, [B, 2] [m/s^2]."""
        state = obs.to_si(observations).astype(np.float64)
        speed, way = self._ahead(state, obs.V_E, obs.A_E)
        front_speed, front_way = self._ahead(state, obs.V_F, obs.A_F)
        stop = self._stop(speed, state[:, obs.D_D] - way)
        follow = self._follow(speed, front_speed, state[:, obs.D_F] + front_way - way)
        return np.stack((stop, follow), axis=1)

    def _ahead(self, state: Floats, speed: int, accel: int) -> tuple[Floats, Floats]:
        """Return the speed one lag ahead, if the acceleration lasts, and the way until then, [B] each."""
        after = np.maximum(state[:, speed] + self._lag * state[:, accel], 0.0)
        return after, 0.5 * self._lag * (state[:, speed] + after)

    def _stop(self, speed: Floats, d_d: Floats) -> Floats:
        profile = np.sqrt(2.0 * self._tuning.decel * np.maximum(d_d - self._aim, 0.0))
        braking = np.where(profile < self._speed_limit, self._tuning.decel, 0.0)
        wanted: Floats = (np.minimum(profile, self._speed_limit) - speed) / self._tuning.response - braking
        return wanted

    def _follow(self, speed: Floats, front_speed: Floats, gap: Floats) -> Floats:
        accel, decel = self._tuning.accel, self._tuning.decel
        closing = speed * (speed - front_speed) / (2.0 * np.sqrt(accel * decel))
        wanted_gap = self._standstill_gap + np.maximum(speed * self._tuning.headway + closing, 0.0)
        free, crowding = (speed / self._speed_limit) ** 4, (wanted_gap / np.maximum(gap, 0.1)) ** 2
        wanted: Floats = accel * (1.0 - free - crowding)
        return wanted
