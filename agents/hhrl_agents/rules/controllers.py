"""The analytic controllers, one for each sub-goal, and the agents that act through them.

A controller maps the state in SI units to a wanted acceleration; the agent takes the nearest of the discrete levels. To
add a sub-goal, write its controller here and name it in ``CONTROLLERS``.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from hhrl_agents.rules.tuning import PAPER_TUNING, Tuning
from hhrl_envs import SUB_GOALS, Option, Scenario
from hhrl_envs import observation as obs
from hhrl_envs.arrays import Flags, Floats, Floats32, Ints

SLOWEST = 0.05
"""Floor of a speed in a denominator [m/s]."""

Controller = Callable[[Floats], Floats]
"""Returns the wanted acceleration [B] [m/s^2] for the SI state [B, elements]."""


@dataclass(frozen=True)
class StopAtStopLine:
    """Stop in the stop zone, along the speed profile of constant comfortable braking (SSL).

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
        aim, limit = road.stop_zone * tuning.aim, road.speed_limit * tuning.speed_share
        return cls(aim, limit, lag, tuning.decel, tuning.response)

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
        gap, limit = scenario.reward.safe_gap + tuning.gap_margin, scenario.road.speed_limit * tuning.speed_share
        return cls(limit, gap, tuning.headway, tuning.accel, tuning.decel)

    def __call__(self, state: Floats) -> Floats:
        """Return the wanted acceleration; see `Controller`."""
        speed = state[:, obs.V_E]
        closing = speed * (speed - state[:, obs.V_F]) / (2.0 * np.sqrt(self.accel * self.decel))
        wanted_gap = self.standstill_gap + np.maximum(speed * self.headway + closing, 0.0)
        gap = np.maximum(state[:, obs.D_F], 0.1)
        wanted: Floats = self.accel * (1.0 - (speed / self.speed_limit) ** 4 - (wanted_gap / gap) ** 2)
        return wanted


@dataclass(frozen=True)
class KeepSafeSpeed:
    """Drive as fast as lets the vehicle stop behind the front vehicle if that brakes, at most as fast as allowed (FFV).

    The safe speed v solves v T + v^2 / (2 b) = s + v_f^2 / (2 b_f), with the time gap T, the planned deceleration b,
    the gap s beyond that at a standstill, and the deceleration b_f that the front vehicle is expected to brake with.
    The wanted acceleration removes the speed error and adds the change of v itself, so that the vehicle starts with the
    front vehicle and brakes with it. Source: Gipps, "A behavioural car-following model for computer simulation",
    Transp. Res. B 15 (1981).
    """

    speed_limit: float
    standstill_gap: float
    headway: float
    decel: float
    leader_decel: float
    response: float
    accel: float

    @classmethod
    def for_scenario(cls, scenario: Scenario, tuning: Tuning) -> "KeepSafeSpeed":
        """Return the controller that stands ``gap_margin`` further than the scenario's d_0 behind the front vehicle."""
        return cls(
            scenario.road.speed_limit * tuning.speed_share,
            scenario.reward.safe_gap + tuning.gap_margin,
            tuning.headway,
            tuning.front_decel,
            tuning.leader_decel,
            tuning.response,
            tuning.accel,
        )

    def __call__(self, state: Floats) -> Floats:
        """Return the wanted acceleration; see `Controller`."""
        speed, front_speed = state[:, obs.V_E], state[:, obs.V_F]
        reaction, credit = self.decel * self.headway, self.decel / self.leader_decel * front_speed
        room = np.maximum(state[:, obs.D_F] - self.standstill_gap, 0.0)
        safe = np.sqrt(reaction * reaction + 2.0 * self.decel * room + credit * front_speed) - reaction
        gained = self.decel * (front_speed - speed) + credit * state[:, obs.A_F]
        change = np.where(safe < self.speed_limit, gained / (safe + reaction + SLOWEST), 0.0)
        wanted = (np.minimum(safe, self.speed_limit) - speed) / self.response + change
        return np.minimum(wanted, self.accel)


FOLLOWERS: Mapping[str, Callable[[Scenario, Tuning], Controller]] = MappingProxyType(
    {"idm": FollowFrontVehicle.for_scenario, "safe speed": KeepSafeSpeed.for_scenario}
)
"""The constructors of the controllers that follow, by the names that a `Tuning` has for them."""


def _follower(scenario: Scenario, tuning: Tuning) -> Controller:
    return FOLLOWERS[tuning.follower](scenario, tuning)


CONTROLLERS: Mapping[Option, Callable[[Scenario, Tuning], Controller]] = MappingProxyType(
    {Option.SSL: StopAtStopLine.for_scenario, Option.FFV: _follower}
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
        self._change, self._urgent = tuning.jerk * (scenario.vehicle.lag + scenario.dt), tuning.urgent
        self._controllers = [CONTROLLERS[sub_goal.option](scenario, tuning) for sub_goal in SUB_GOALS]

    def reset(self, mask: Flags) -> None:
        """Do nothing: there is nothing to forget."""

    def act_with_option(self, observations: Floats32, option: Ints) -> Ints:
        """Return the actions of the options' controllers, int64 [B]; see `HierarchicalAgent.act_with_option`."""
        state = self.si_state(observations)
        return self.pursue(state, self.wanted(state), option)

    def si_state(self, observations: Floats32) -> Floats:
        """Return the state that the controllers read, float64 [B, elements] in SI units."""
        return obs.to_si(observations).astype(np.float64)

    def wanted(self, state: Floats) -> Floats:
        """Return the acceleration that each sub-goal's controller wants, [B, options] [m/s^2]."""
        return np.stack([controller(state) for controller in self._controllers], axis=1)

    def pursue(self, state: Floats, wanted: Floats, option: Ints) -> Ints:
        """Return the levels, int64 [B], that `smooth_levels` takes for what the controllers of the options want."""
        chosen = wanted[np.arange(len(option)), option]
        return smooth_levels(self._levels, chosen, state[:, obs.A_E], self._change, self._urgent)


def predict(state: Floats, seconds: float) -> Floats:
    """Return the SI state after `seconds` in which the accelerations of ego and front vehicle last.

    Speeds and distances are predicted; the elements that derive from them stay as they are.
    """
    ahead = state.copy()
    ego_way, front_way = (
        _advance(state, ahead, speed, accel, seconds) for speed, accel in ((obs.V_E, obs.A_E), (obs.V_F, obs.A_F))
    )
    ahead[:, obs.D_D] = state[:, obs.D_D] - ego_way
    ahead[:, obs.D_F] = state[:, obs.D_F] + front_way - ego_way
    return ahead


def _advance(state: Floats, ahead: Floats, speed: int, accel: int, seconds: float) -> Floats:
    """Write a vehicle's speed after that time into `ahead`; return the way until then, [B] [m]."""
    ahead[:, speed] = np.maximum(state[:, speed] + seconds * state[:, accel], 0.0)
    way: Floats = 0.5 * seconds * (state[:, speed] + ahead[:, speed])
    return way


def nearest_levels(levels: Floats, accelerations: Floats) -> Ints:
    """Return the index of the level nearest to each acceleration, the lower one on a tie.

    levels: ascending target accelerations, [A] [m/s^2]; accelerations: [B] [m/s^2].
    """
    midpoints = (levels[1:] + levels[:-1]) / 2
    return np.searchsorted(midpoints, accelerations, side="left").astype(np.int64)


def smooth_levels(levels: Floats, wanted: Floats, accel: Floats, change: float, urgent: float) -> Ints:
    """Return the index of the level nearest to each wanted acceleration [B] that is within `change` of the present one.

    Below -`urgent` any lower level will do. Where no level is within `change`, the one nearest to the present
    acceleration is taken. All accelerations are in m/s^2; `levels` are ascending, [A].
    """
    lowest = np.where(wanted < -urgent, 0, np.searchsorted(levels, accel - change, side="left"))
    highest = np.searchsorted(levels, accel + change, side="right") - 1
    within = np.minimum(np.maximum(nearest_levels(levels, wanted), lowest), highest)
    return np.where(lowest <= highest, within, nearest_levels(levels, accel)).astype(np.int64)
