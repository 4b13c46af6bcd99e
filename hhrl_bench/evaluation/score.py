"""The score: how well an episode was driven, from 0 to 1, by metrics of the registry.

It has the form of nuPlan's closed-loop score, gates times a weighted mean::

    score    = [SUCCESS] * progress * (w_comfort * comfort + w_margin * margin) / (w_comfort + w_margin)
    progress = fewest_steps / steps, at most 1
    comfort  = share of the steps within the bounds of acceleration and jerk
    margin   = share of the steps with d_fc >= 0 and a time to collision within its bound

SUCCESS excludes a collision, a crossed line and the time limit. ``fewest_steps`` is what the quickest way to the goal
takes that the vehicle can drive, found by the oracle, which knows how the traffic will; where it finds none, or where
the goal is to follow until the horizon, progress is 1. In worlds with learned front vehicles, whose future nobody
knows, there is no progress and no score. Acceleration, jerk and distances are the true ones, however wrong the
sensors are; a front vehicle beyond their range counts as none.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from hhrl_agents.rules.oracle import COMFORTABLE, Oracle
from hhrl_bench.evaluation.metric import Measured
from hhrl_envs import Outcome, Scenario, Simulator
from hhrl_envs.arrays import Flags, Floats, Ints, Keys
from hhrl_envs.simulation import rewards
from hhrl_envs.sub_goals import Option

if TYPE_CHECKING:
    from hhrl_bench.evaluation.rollout import Rollout, Step


@dataclass(frozen=True)
class Bounds:
    """What counts as comfortable and as a margin, beside d_fc >= 0 of the paper's Eq. (dis).

    The bounds are those of nuPlan's closed-loop score (Caesar et al., "nuPlan: A closed-loop ML-based planning
    benchmark for autonomous vehicles", 2021). With another bound, weight or form, entries have another
    ``schema_version``.
    """

    accel: tuple[float, float] = COMFORTABLE  # m/s^2
    jerk: float = 4.13  # m/s^3, either way
    time_to_collision: float = 0.95  # s


@dataclass(frozen=True)
class Weights:
    """How much the parts count: comfort and margin in their mean, progress as the power that it is raised to."""

    progress: float = 1.0
    comfort: float = 1.0
    margin: float = 1.0


BOUNDS, WEIGHTS = Bounds(), Weights()


def fewest_steps(rollout: "Rollout") -> Ints | None:
    """Return the steps of the quickest way to the goal in the worlds of a rollout, int64 [B]; 0 where none was found.

    It is None with learned front vehicles.
    """
    simulator = rollout.simulator
    if simulator.num_agents > 1:
        return None
    known = _known(simulator.scenario)
    if len(known) > MOST_KNOWN:
        known.clear()
    new = np.setdiff1d(rollout.seeds, np.fromiter(known, np.uint64, len(known)))
    if new.size:
        known.update(zip(new.tolist(), _fewest_steps(simulator.scenario, new).tolist(), strict=True))
    return np.array([known[seed] for seed in rollout.seeds.tolist()], np.int64)


MOST_KNOWN = 200_000
"""Worlds of a scenario whose fewest steps are kept: every agent is scored in the same ones."""


@lru_cache(maxsize=16)
def _known(_: Scenario) -> dict[int, int]:
    """Return the fewest steps in the worlds of a scenario, by their seeds, that have been found so far."""
    return {}


def _fewest_steps(scenario: Scenario, worlds: Keys) -> Ints:
    """Return the fewest steps in episode 0 of worlds, uint64 [B]."""
    simulator, oracle = Simulator(scenario, len(worlds)), Oracle(scenario)
    simulator.reset(worlds)
    oracle.foresee(simulator)
    return oracle.fewest


def uncomfortable(step: "Step") -> Flags:
    """Return whether a step's true acceleration or jerk is out of bounds, bool [B]."""
    accel, jerk = step.simulator.motion(step.slots[0])[:, 2:].T
    low, high = BOUNDS.accel
    beyond: Flags = (accel < low) | (accel > high) | (np.abs(jerk) > BOUNDS.jerk)
    return beyond


def too_close(step: "Step") -> Flags:
    """Return whether the front vehicle is nearer after a step than the bounds allow, bool [B]."""
    unsafe: Flags = step.results.terms[:, rewards.UNSAFE[Option.FFV]] < 0.0
    return unsafe | (step.time_to_collision < BOUNDS.time_to_collision)


def progress(episodes: Measured) -> Floats:
    """Return the fewest steps as a share of those taken, at most 1, float64 [N]; 1 where no way was found."""
    fewest, steps = (np.asarray(values, np.float64) for values in (episodes.measured["fewest_steps"], episodes.steps))
    return np.where(fewest > 0.0, np.minimum(fewest / steps, 1.0), 1.0)


def share_without(key: str, episodes: Measured) -> Floats:
    """Return the share of an episode's steps that a metric does not count, float64 [N]."""
    share: Floats = 1.0 - np.asarray(episodes.measured[key], np.float64) / np.asarray(episodes.steps, np.float64)
    return share


def comfort(episodes: Measured) -> Floats:
    """Return the share of comfortable steps, float64 [N]."""
    return share_without("uncomfortable", episodes)


def margin(episodes: Measured) -> Floats:
    """Return the share of steps that keep the margin, float64 [N]."""
    return share_without("too_close", episodes)


def score(episodes: Measured, weights: Weights = WEIGHTS) -> Floats:
    """Return the score of episodes, float64 [N], with other weights if they are given."""
    succeeded = np.asarray(episodes.outcome == int(Outcome.SUCCESS), np.float64)
    parts = weights.comfort * comfort(episodes) + weights.margin * margin(episodes)
    made = progress(episodes)
    powered = made if weights.progress == 1.0 else made**weights.progress
    scores: Floats = succeeded * powered * (parts / (weights.comfort + weights.margin))
    return scores
