"""The oracle: it knows how the scripted traffic will drive, and so what is possible in every single episode."""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from hhrl_agents.agent import NO_OPTION, ClairvoyantAgent, Decision
from hhrl_agents.rules.plans import Body, Caps, Goals, follow_rows, plan_rows
from hhrl_envs import Goal, Scenario, Simulator
from hhrl_envs.arrays import Codes, Flags, Floats, Floats32, Ints
from hhrl_envs.errors import InputError
from hhrl_envs.scenario.limits import WEAKEST
from hhrl_envs.scenario.scenario import GRAVITY

COMFORTABLE = (-4.05, 2.40)
"""The accelerations [m/s^2] that passengers take for comfortable, as nuPlan's closed-loop score bounds them."""

TOLERANCES = (0.1, 0.01)
"""How far beyond the near end of the stop zone plans aim, as shares of it.

A wide aim takes fewer steps; a narrow one fits behind a front vehicle that stands in the zone itself.
"""

KEPT_GAP = 1.0  # m; how much more than it must the oracle keeps to whom it follows


class Manner(NamedTuple):
    """How an ego drives to its goal.

    Attributes:
        gap: the free road [m] that it keeps to its front vehicle at least.
        weakest, strongest: its accelerations [m/s^2].
    """

    gap: float = 0.0
    weakest: float = -np.inf
    strongest: float = np.inf

    def levels(self, scenario: Scenario) -> Ints:
        """Return the scenario's levels that it uses, as indices."""
        levels = np.array(scenario.vehicle.levels)
        return np.flatnonzero((levels >= self.weakest) & (levels <= self.strongest))


class Future(NamedTuple):
    """What B worlds hold in store for their egos, after 0, 1, 2, ... steps.

    Attributes:
        motions: position [m], speed [m/s], acceleration [m/s^2] and jerk [m/s^3] of the egos now, float64 [B, 4].
        rears: the positions [m] of the rear of their front vehicles, float64 [B, horizon + 1].
        closed: the first positions [m] behind the line while its light is red, else infinite, float64 [B, horizon + 1].
        grips: the most that the road lets the egos accelerate and brake with [m/s^2], float64 [B].
    """

    motions: Floats
    rears: Floats
    closed: Floats
    grips: Floats

    def ceilings(self, gap: float) -> Floats:
        """Return the positions [m], float64 [B, horizon + 1], that egos which keep a gap may not reach."""
        ceilings: Floats = np.minimum(self.rears - gap, self.closed)
        return ceilings


ANY = Manner()
"""All that the vehicle can do."""


class Plans(NamedTuple):
    """What an ego that knows the future would do in B worlds.

    Attributes:
        steps: after how many steps it is at the goal, int64 [B]; 0 where it finds no way there in time.
        actions: its levels, int8 [B, horizon].
    """

    steps: Ints
    actions: Codes


def foresee(simulator: Simulator) -> Future:
    """Return the future of the worlds of a simulator, which stays as it is.

    A copy of it is driven ahead with egos that brake: scripted vehicles do not react to the ego behind them.

    Raises:
        InputError: if front vehicles are agents, whose future nobody knows.
    """
    scenario, rows = simulator.scenario, simulator.num_rows
    if simulator.num_agents > 1:
        raise InputError(f"the oracle foresees scripted traffic alone; {scenario.id} has learned front vehicles")
    ahead, brake = Simulator(scenario, rows), np.zeros(rows, np.int64)
    ahead.restore(simulator.state())
    rears, closed = np.empty((rows, scenario.horizon + 1)), np.full((rows, scenario.horizon + 1), np.inf)
    for t in range(scenario.horizon + 1):
        rears[:, t] = ahead.motion(1)[:, 0] - scenario.vehicle.length
        if scenario.signal is not None:
            closed[:, t] = np.nextafter(ahead.lines, np.inf)
        ahead.step(brake)
    return Future(simulator.motion(0), rears, closed, simulator.friction * GRAVITY)


def quickest(future: Future, scenario: Scenario, manner: Manner = ANY) -> Plans:
    """Return the quickest plans to the scenario's goal in this manner, with the levels that it allows.

    Where the goal is to follow, time is no matter: the plans keep near the front vehicle until the horizon.
    """
    levels, body, ceilings = np.array(scenario.vehicle.levels), _body(scenario), future.ceilings(manner.gap)
    usable, grips = manner.levels(scenario), future.grips
    caps = Caps(int(usable[0]), int(usable[-1]))
    if scenario.goal == Goal.FOLLOW:
        plans, band = _all_braking(future, scenario, caps), max(scenario.band.low - manner.gap, 0.0)
        follow_rows(future.motions, ceilings, band + KEPT_GAP, levels, caps, body, grips, *plans)
        return plans
    road, passing = scenario.road, scenario.goal == Goal.PASS
    ends, found = np.array([scenario.route_end] if passing else road.lines), []
    for tolerance in TOLERANCES:
        found.append(_all_braking(future, scenario, caps))
        goals = Goals(road.stop_zone, road.stop_speed, tolerance * road.stop_zone, passing)
        plan_rows(future.motions, ceilings, ends, levels, caps, goals, body, grips, *found[-1])
    return quicker(*found)


def quicker(*found: Plans) -> Plans:
    """Return the plan of the fewest steps for each of B worlds, the first of equal ones."""
    steps = np.stack([plans.steps for plans in found])
    best = np.where(steps > 0, steps, np.iinfo(np.int64).max).argmin(axis=0)
    rows = np.arange(steps.shape[1])
    return Plans(steps[best, rows], np.stack([plans.actions for plans in found])[best, rows])


def _all_braking(future: Future, scenario: Scenario, caps: Caps) -> Plans:
    rows = len(future.motions)
    return Plans(np.zeros(rows, np.int64), np.full((rows, scenario.horizon), caps.brake, np.int8))


def _body(scenario: Scenario) -> Body:
    vehicle, dt = scenario.vehicle, scenario.dt
    gain, most = dt / (vehicle.lag + dt), vehicle.jerk_limit * dt
    return Body(dt, gain, most, scenario.road.speed_limit)


def manners(scenario: Scenario) -> tuple[Manner, ...]:
    """Return how the oracle drives: in the first of these manners that leads to the goal.

    Comfortable ones are those of a vehicle that has a brake and a throttle within `COMFORTABLE`.
    """
    comfortable = Manner(scenario.reward.safe_gap, *COMFORTABLE), Manner(0.0, *COMFORTABLE)
    used = np.array(scenario.vehicle.levels)[comfortable[0].levels(scenario)]
    return (*comfortable, ANY) if used.size and used[0] <= -WEAKEST and used[-1] >= WEAKEST else (ANY,)


class Oracle:
    """A `ClairvoyantAgent` that takes the quickest way to the goal, comfortably and at the safe gap where it can.

    Where no way of `COMFORTABLE` accelerations that keeps the gap d_0 leads there, it gives up the gap, and then the
    comfort; see `manners`.

    Attributes:
        fewest: the steps to the goal of the quickest way that the vehicle can take, int64 [B]; 0 where none was found.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._scenario, self._step = scenario, 0
        self.fewest, self._actions = np.zeros(0, np.int64), np.zeros((0, 0), np.int8)

    def foresee(self, simulator: Simulator) -> None:
        """Plan for all worlds; see `ClairvoyantAgent.foresee`."""
        future = foresee(simulator)
        found = [quickest(future, self._scenario, manner) for manner in manners(self._scenario)]
        self.fewest = quicker(*found).steps
        leads = np.stack([plans.steps for plans in found]) > 0
        chosen, rows = leads.argmax(axis=0), np.arange(len(self.fewest))
        self._actions = np.stack([plans.actions for plans in found])[chosen, rows]
        self._step = 0

    def reset(self, mask: Flags) -> None:
        """Do nothing: `foresee` has planned the whole episodes."""

    def act(self, observations: Floats32) -> Decision:
        """Return the planned actions of the next step, int64 [B]; see `Agent.act`."""
        rows, last = len(observations), self._actions.shape[1] - 1
        action = self._actions[:, min(self._step, last)].astype(np.int64)
        self._step += 1
        return Decision(np.full(rows, NO_OPTION, np.int64), action)


ORACLES: Mapping[str, Callable[[Scenario], ClairvoyantAgent]] = MappingProxyType({"oracle": Oracle})
"""The constructors of the clairvoyant agents by their ids."""
