"""What the PettingZoo, Gymnasium and vector views share: spaces and infos."""

from typing import Any

import numpy as np
from gymnasium import spaces

from hhrl_envs import observation as o
from hhrl_envs.outcomes import Outcome
from hhrl_envs.scenario import Scenario
from hhrl_envs.simulator import Simulator
from hhrl_envs.traffic import HARDEST_DECEL

Info = dict[str, Any]


def observation_space(scenario: Scenario) -> spaces.Box:
    """Return the box that holds every scaled observation of the scenario, float32 [11]."""
    limit, reach = scenario.road.speed_limit, scenario.road.sensor_range
    brake, throttle = scenario.vehicle.levels[0], scenario.vehicle.levels[-1]
    start, step = scenario.road.start_distance[1], limit * scenario.dt
    longest = max(limit * limit / (2.0 * scenario.vehicle.max_decel), scenario.reward.safe_gap)
    front = max(limit, scenario.traffic.speed[1], *(family.desired_speed[1] for family in scenario.traffic.families))
    jerk, front_accel = (throttle - brake) / scenario.dt, 2.0 * HARDEST_DECEL
    low, high = np.zeros(o.SIZE, np.float32), np.zeros(o.SIZE, np.float32)
    high[[o.V_E, o.A_E, o.J_E]] = limit, throttle, jerk
    low[[o.V_E, o.A_E, o.J_E]] = 0.0, brake, -jerk
    high[[o.D_F, o.V_F, o.A_F]] = reach, front + 1.0, front_accel
    low[[o.D_F, o.V_F, o.A_F]] = 0.0, 0.0, -front_accel
    high[[o.D_FC, o.D_D, o.D_DC]] = reach, start, start
    low[[o.D_FC, o.D_D, o.D_DC]] = -longest, -step, -step - longest
    high[[o.FC_RATIO, o.DC_RATIO]] = o.RATIO_HIGH
    low[[o.FC_RATIO, o.DC_RATIO]] = o.RATIO_LOW
    return spaces.Box(low * o.SCALES, high * o.SCALES, dtype=np.float32)


def action_space(scenario: Scenario) -> spaces.Discrete:
    """Return the discrete throttle and brake levels of the scenario."""
    return spaces.Discrete(scenario.num_actions)


def reset_info(simulator: Simulator, row: int) -> Info:
    """Return a row's info at reset: front vehicles' profiles, feasibility, option mask, (seed, episode)."""
    seed, episode = simulator.key(row)
    return {
        "profiles": simulator.profiles(row),
        "feasible": bool(simulator.feasible[row]),
        "option_mask": np.array(simulator.scenario.option_mask),
        "seed": seed,
        "episode": episode,
    }


def step_info(simulator: Simulator, row: int) -> Info:
    """Return a row's info after a step: r^option and r^action of every option, and the outcome once there is one."""
    info: Info = {
        "reward_option": simulator.reward_option[row].copy(),
        "reward_action": simulator.reward_action[row].copy(),
    }
    if simulator.outcomes[row]:
        info["outcome"] = Outcome(simulator.outcomes[row])
    return info


def is_terminal(outcome: int) -> bool:
    """Return whether an outcome terminates the episode (a time limit truncates it)."""
    return outcome not in (Outcome.RUNNING, Outcome.TIMEOUT)
