"""The analytic controllers, one for each sub-goal, and the agents that act through them.

A controller maps the state in SI units to a wanted acceleration; the agent takes the nearest of the discrete levels. To
add a sub-goal, write its controller here and name it in ``CONTROLLERS``.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from hhrl_envs import SUB_GOALS, Option, Scenario
from hhrl_envs import observation as obs
from hhrl_envs.arrays import Flags, Floats, Floats32, Ints

COMFORT = 2.0
"""Deceleration that a controller plans with [m/s^2]."""


@dataclass(frozen=True)
class Tuning:
    """How the controllers of an agent drive.

    The defaults are those of `RulePlus`. Its deceleration is the comfortable one of the other rules; the rest was
    chosen once, for the highest mean return on the first 2,000 validation worlds of stop-line-v0; the optimum is flat.

    Attributes:
        headway: time gap to the front vehicle [s].
        decel: deceleration that stops are planned with [m/s^2].
        gap_margin: what the gap at a standstill exceeds d_0 of Eq. (dis) by [m]; a gap below d_0 counts as unsafe.
        response: time in which a speed error is removed [s].
        accel: acceleration of the follower [m/s^2].
        predicted: whether the state that they are given is that of `one_lag_ahead`, so that no controller has to
            reckon with the actuator's lag.
    """

    headway: float = 1.5
    decel: float = COMFORT
    gap_margin: float = 1.0
    response: float = 1.0
    accel: float = 1.5
    predicted: bool = True


PLUS_TUNING = Tuning()
"""How `RulePlus` drives."""

PAPER_TUNING = Tuning(headway=1.0, response=0.5, accel=2.0, predicted=False)
"""How the rules of Table I drive. The headway is short, for the rule that always follows collides in 18% there."""

Controller = Callable[[Floats], Floats]
"""Returns the wanted acceleration [B] [m/s^2] for the SI state [B, elements]."""


@dataclass(frozen=True)
class StopAtStopLine:
    """Stop in the middle of the stop zone, along the speed profile of constant comfortable braking (SSL).

    The reference speed is v(x) = sqrt(2 b x) with x the way left to the aim. It is positive everywhere before the stop
    zone, so a vehicle that stands too early moves up instead of waiting or creeping. `lag` [s] is the time that passes
    at the present speed before a level takes effect.
    """

    aim: float
    speed_limit: float
    lag: float
    decel: float
    response: float

    @classmethod
    def for_scenario(cls, scenario: Scenario, tuning: Tuning = PAPER_TUNING) -> "StopAtStopLine":
        """Return the controller that stops in the scenario's stop zone with its vehicle."""
        road, lag = scenario.road, 0.0 if tuning.predicted else scenario.vehicle.lag
        return cls(road.stop_zone / 2, road.speed_limit, lag, tuning.decel, tuning.response)

    def __call__(self, state: Floats) -> Floats:
        """Return the wanted acceleration; see `Controller`."""
        speed = state[:, obs.V_E]
        way = np.maximum(state[:, obs.D_D] - self.aim - self.lag * speed, 0.0)
        profile = np.sqrt(2.0 * self.decel * way)
        braking = np.where(profile < self.speed_limit, self.decel, 0.0)
        wanted: Floats = (np.minimum(profile, self.speed_limit) - speed) / self.response - braking
        return wanted


@dataclass(frozen=True)
class FollowFrontVehicle:
    """Follow the front vehicle as the intelligent driver model does, at the speed limit when there is none (FFV).

    Source: Treiber, Hennecke, Helbing, "Congested traffic states in empirical observations and microscopic
    simulations", Phys. Rev. E 62 (2000).
    """

    speed_limit: float
    standstill_gap: float
    headway: float
    accel: float
    decel: float

    @classmethod
    def for_scenario(cls, scenario: Scenario, tuning: Tuning = PAPER_TUNING) -> "FollowFrontVehicle":
        """Return the controller that keeps more than the scenario's d_0 behind the front vehicle."""
        gap = scenario.reward.safe_gap + tuning.gap_margin
        return cls(scenario.road.speed_limit, gap, tuning.headway, tuning.accel, tuning.decel)

    def __call__(self, state: Floats) -> Floats:
        """Return the wanted acceleration; see `Controller`."""
        speed = state[:, obs.V_E]
        closing = speed * (speed - state[:, obs.V_F]) / (2.0 * np.sqrt(self.accel * self.decel))
        wanted_gap = self.standstill_gap + np.maximum(speed * self.headway + closing, 0.0)
        gap = np.maximum(state[:, obs.D_F], 0.1)
        wanted: Floats = self.accel * (1.0 - (speed / self.speed_limit) ** 4 - (wanted_gap / gap) ** 2)
        return wanted


CONTROLLERS: Mapping[Option, Callable[[Scenario, Tuning], Controller]] = MappingProxyType(
    {Option.SSL: StopAtStopLine.for_scenario, Option.FFV: FollowFrontVehicle.for_scenario}
)
"""The constructor of each sub-goal's controller."""


class ControllerAgent:
    """What agents without memory share whose actions are the controllers'; a subclass selects the option.

    Attributes:
        option_mask: which options the scenario has, bool [options].
    """

    def __init__(self, scenario: Scenario, tuning: Tuning) -> None:
        self.option_mask: Flags = np.asarray(scenario.option_mask)
        self._levels = np.asarray(scenario.vehicle.levels, dtype=np.float64)
        self._controllers = [CONTROLLERS[sub_goal.option](scenario, tuning) for sub_goal in SUB_GOALS]

    def reset(self, mask: Flags) -> None:
        """Do nothing: there is nothing to forget."""

    def act_with_option(self, observations: Floats32, option: Ints) -> Ints:
        """Return the actions of the options' controllers, int64 [B]; see `HierarchicalAgent.act_with_option`."""
        return self.pursue(self.wanted(self.si_state(observations)), option)

    def si_state(self, observations: Floats32) -> Floats:
        """Return the state that the controllers read, float64 [B, elements] in SI units."""
        return obs.to_si(observations).astype(np.float64)

    def wanted(self, state: Floats) -> Floats:
        """Return the acceleration that each sub-goal's controller wants, [B, options] [m/s^2]."""
        return np.stack([controller(state) for controller in self._controllers], axis=1)

    def pursue(self, wanted: Floats, option: Ints) -> Ints:
        """Return the levels, int64 [B], nearest to what the controllers of the options want."""
        return nearest_levels(self._levels, wanted[np.arange(len(option)), option])


def one_lag_ahead(state: Floats, lag: float) -> Floats:
    """Return the SI state after `lag` [s] in which the accelerations of ego and front vehicle last.

    Speeds and distances are predicted; the elements that derive from them stay as they are.
    """
    ahead = state.copy()
    ego_way, front_way = (
        _advance(state, ahead, speed, accel, lag) for speed, accel in ((obs.V_E, obs.A_E), (obs.V_F, obs.A_F))
    )
    ahead[:, obs.D_D] = state[:, obs.D_D] - ego_way
    ahead[:, obs.D_F] = state[:, obs.D_F] + front_way - ego_way
    return ahead


def _advance(state: Floats, ahead: Floats, speed: int, accel: int, lag: float) -> Floats:
    """Write a vehicle's speed after the lag into `ahead`; return the way until then, [B] [m]."""
    ahead[:, speed] = np.maximum(state[:, speed] + lag * state[:, accel], 0.0)
    way: Floats = 0.5 * lag * (state[:, speed] + ahead[:, speed])
    return way


def nearest_levels(levels: Floats, accelerations: Floats) -> Ints:
    """Return the index of the level nearest to each acceleration, the lower one on a tie.

    levels: ascending target accelerations, [A] [m/s^2]; accelerations: [B] [m/s^2].
    """
    midpoints = (levels[1:] + levels[:-1]) / 2
    return np.searchsorted(midpoints, accelerations, side="left").astype(np.int64)
