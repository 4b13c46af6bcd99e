"""The spaces of the PettingZoo, Gymnasium and vector views."""

import numpy as np
from gymnasium import spaces

from hhrl_envs import observation as o
from hhrl_envs.scenario.profiles import Range
from hhrl_envs.scenario.scenario import GRAVITY, Scenario
from hhrl_envs.simulation.sub_goal_kernels import KERNELS, Motion
from hhrl_envs.sub_goals import STATE_ORDER


def observation_space(scenario: Scenario) -> spaces.Box:
    """Return the box that holds every scaled observation of the scenario, sensor noise included, float32 [SIZE]."""
    levels, limit, sensor = scenario.vehicle.levels, scenario.road.speed_limit, scenario.sensor
    accel = levels[0] - 6.0 * sensor.noise_accel, levels[-1] + 6.0 * sensor.noise_accel
    return _box(scenario, limit + 6.0 * sensor.noise_speed, accel, limit * scenario.dt)


def state_space(scenario: Scenario, agents: int) -> spaces.Box:
    """Return the box of the global state: the agents' observations one after another, float32 [SIZE * agents].

    Those that have left are still seen in it: braking to a stand past the line, or driven on by their profiles. So for
    several agents it is wider than their observation spaces.
    """
    one = observation_space(scenario)
    if agents > 1:
        fastest = float(max(one.high[[o.V_E, o.V_F]] / o.SCALES[[o.V_E, o.V_F]]))
        accel = one.low[o.A_F] / o.SCALES[o.A_F], one.high[o.A_F] / o.SCALES[o.A_F]
        past = scenario.road.speed_limit * scenario.dt + scenario.vehicle.length + _slide(scenario, fastest)
        one = _box(scenario, fastest, accel, past)
    return spaces.Box(np.tile(one.low, agents), np.tile(one.high, agents), dtype=np.float32)


def _box(scenario: Scenario, fastest: float, accel: Range, overshoot: float) -> spaces.Box:
    """Return the box of what an agent sees that drives so fast and accelerates so, until so far past its line."""
    vehicle = scenario.vehicle
    safety = max(fastest * fastest / (2.0 * vehicle.max_decel), scenario.reward.safe_gap)
    rounded = 4.0 * float(np.spacing(fastest)) / scenario.dt  # an acceleration is a difference of two speeds
    jerk = (vehicle.levels[-1] - vehicle.levels[0] + 2.0 * rounded) / scenario.dt
    bounds = [(0.0, fastest), (accel[0] - rounded, accel[1] + rounded), (-jerk, jerk)]
    for goal in STATE_ORDER:
        bounds += KERNELS[goal.option].bounds(scenario, Motion(overshoot, safety))
    low, high = np.array(bounds, np.float32).T * o.SCALES
    return spaces.Box(low, high, dtype=np.float32)


def _slide(scenario: Scenario, speed: float) -> float:
    """Return metres in which an agent with ``speed`` surely stands: those of its reaction, and of its full brake."""
    vehicle = scenario.vehicle
    brake = min(-vehicle.levels[0], scenario.road.frictions[0] * GRAVITY)
    reaction = 2.0 * (vehicle.lag + scenario.dt) + (vehicle.levels[-1] - vehicle.levels[0]) / vehicle.jerk_limit
    return speed * reaction + speed * speed / (2.0 * brake)
