"""What the PettingZoo, Gymnasium and vector views share: spaces and infos."""

from typing import Any

import numpy as np
from gymnasium import spaces

from hhrl_envs import observation as o
from hhrl_envs.scenario.scenario import GRAVITY, Scenario
from hhrl_envs.simulation import sensing
from hhrl_envs.simulation.simulator import Simulator
from hhrl_envs.simulation.traffic import HARDEST_DECEL

Info = dict[str, Any]


def observation_space(scenario: Scenario) -> spaces.Box:
    """Return the box that holds every scaled observation of the scenario, sensor noise included, float32 [11]."""
    road, vehicle, sensor = scenario.road, scenario.vehicle, scenario.sensor
    speed, accel, distance = (6.0 * noise for noise in (sensor.noise_speed, sensor.noise_accel, sensor.noise_distance))
    fastest, step = road.speed_limit + speed, road.speed_limit * scenario.dt
    front = max(road.speed_limit, scenario.traffic.speed[1], *(f.desired_speed[1] for f in scenario.traffic.families))
    safety = max(fastest * fastest / (2.0 * vehicle.max_decel), scenario.reward.safe_gap)
    jerk, hardest = (vehicle.levels[-1] - vehicle.levels[0]) / scenario.dt, 2.0 * HARDEST_DECEL + accel
    far, line = sensor.front_range + distance, max(road.start_distance[1], sensor.line_range) + distance
    bounds = {
        o.V_E: (0.0, fastest),
        o.A_E: (vehicle.levels[0] - accel, vehicle.levels[-1] + accel),
        o.J_E: (-jerk, jerk),
        o.D_F: (0.0, far),
        o.V_F: (0.0, front + 1.0 + speed),
        o.A_F: (-hardest, hardest),
        o.D_FC: (-safety, far),
        o.FC_RATIO: (sensing.RATIO_LOW, sensing.RATIO_HIGH),
        o.D_D: (-step - distance, line),
        o.D_DC: (-step - distance - safety, line),
        o.DC_RATIO: (sensing.RATIO_LOW, sensing.RATIO_HIGH),
    }
    low, high = np.array([bounds[index] for index in range(o.SIZE)], np.float32).T * o.SCALES
    return spaces.Box(low, high, dtype=np.float32)


def state_space(scenario: Scenario, agents: int) -> spaces.Box:
    """Return the box of the global state: the agents' observations one after another, float32 [11 * agents].

    Those that have left are still seen in it: braking to a stand past the line, or driven on by their profiles. So for
    several agents it is wider than their observation spaces.
    """
    one = observation_space(scenario)
    low, high = one.low.copy(), one.high.copy()
    if agents > 1:
        fastest = high[o.V_E] = max(high[o.V_E], high[o.V_F])
        low[o.A_E], high[o.A_E] = low[o.A_F], high[o.A_F]
        speed = float(fastest / o.SCALES[o.V_E])
        safety = speed * speed / (2.0 * scenario.vehicle.max_decel)
        low[o.D_D] -= (scenario.vehicle.length + _slide(scenario, speed)) * o.SCALES[o.D_D]
        low[o.D_DC] = low[o.D_D] - safety * o.SCALES[o.D_DC]
        low[o.D_FC] = min(low[o.D_FC], -safety * o.SCALES[o.D_FC])
    return spaces.Box(np.tile(low, agents), np.tile(high, agents), dtype=np.float32)


def _slide(scenario: Scenario, speed: float) -> float:
    """Return metres in which an agent with ``speed`` surely stands: those of its reaction, and of its full brake."""
    vehicle = scenario.vehicle
    brake = min(-vehicle.levels[0], scenario.road.friction * GRAVITY)
    reaction = 2.0 * (vehicle.lag + scenario.dt) + (vehicle.levels[-1] - vehicle.levels[0]) / vehicle.jerk_limit
    return speed * reaction + speed * speed / (2.0 * brake)


def reset_info(simulator: Simulator, row: int) -> Info:
    """Return a row's info at reset: front vehicles' profiles, feasibility, option mask, (seed, episode)."""
    seed, episode = simulator.key(row)
    return {
        "profiles": simulator.profiles(row),
        "feasible": bool(simulator.feasible[row]) if simulator.num_agents == 1 else None,
        "option_mask": np.array(simulator.scenario.option_mask),
        "seed": seed,
        "episode": episode,
    }
