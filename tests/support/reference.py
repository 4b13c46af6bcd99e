"""The paper's equations in plain Python, written for the tests alone: one row, one step, no arrays."""

from dataclasses import dataclass
from math import exp

import numpy as np
from numpy.typing import NDArray

from hhrl_envs import Outcome, Scenario


@dataclass
class Facts:
    """What an observer outside the simulator sees of one step."""

    v_e: float
    j_e: float
    d_d: float
    d_f: float
    v_f: float
    outcome: Outcome


def distances(facts: Facts, scenario: Scenario) -> dict[str, float]:
    """Eq. (dis), with the documented sensor range."""
    a_max, d_0 = scenario.vehicle.max_decel, scenario.reward.safe_gap
    seen = facts.d_f <= scenario.sensor.front_range
    d_f = max(facts.d_f, 0.0) if seen else scenario.sensor.front_range
    v_f = facts.v_f if seen else scenario.road.speed_limit
    d_fs = max((facts.v_e**2 - v_f**2) / (2 * a_max), d_0)
    d_ds = facts.v_e**2 / (2 * a_max)
    return {"d_fs": d_fs, "d_fc": d_f - d_fs, "d_ds": d_ds, "d_dc": facts.d_d - d_ds}


def unsafe_terms(d: dict[str, float], reading: str) -> list[float]:
    """exp(-d_c / d_s) of SSL and FFV where d_c < 0: with d_ds floored and the exponent bounded, or as it is printed."""
    floor, most = {"floored": (0.5, 1.0), "printed": (0.0, 32.0)}[reading]
    return [unsafe(d["d_dc"], max(d["d_ds"], floor), most), unsafe(d["d_fc"], d["d_fs"], most)]


def unsafe(chased: float, reference: float, most: float) -> float:
    if chased >= 0.0:
        return 0.0
    return exp(most if reference * most <= -chased else -chased / reference)


def rewards(facts: Facts, scenario: Scenario) -> tuple[float, list[float], list[float]]:
    """r^task, r^option and r^action of both options, event by event."""
    r, d = scenario.reward, distances(facts, scenario)
    unsafe_of = unsafe_terms(d, r.unsafe)
    failure_of = [
        facts.v_e**2 if facts.outcome == Outcome.NOT_STOP else 0.0,
        r.sigma_3 if facts.outcome == Outcome.COLLISION else 0.0,
    ]
    jerk = r.sigma_2 if abs(facts.j_e) > r.jerk_threshold else 0.0
    sr = -r.sigma_1
    if facts.outcome == Outcome.TIMEOUT:
        sr -= r.timeout_scale * facts.d_d**2
    if facts.outcome == Outcome.SUCCESS:
        sr += r.sigma_4
    option = [sr - unsafe_of[1 - k] - failure_of[1 - k] for k in (0, 1)]
    action = [sr - jerk - unsafe_of[k] - failure_of[k] for k in (0, 1)]
    return sr - jerk - sum(unsafe_of) - sum(failure_of), option, action


def judge(scenario: Scenario, positions: NDArray[np.float64], speed: float, agent: int, step: int) -> Outcome:
    """How the episode of one agent stands: in words, for a single stop-line at position 0 where it has to stop.

    ``positions`` are those of all vehicles, the ego first, NaN or missing where there is none.
    """
    length, x = scenario.vehicle.length, positions[agent]
    if agent + 1 < len(positions) and positions[agent + 1] - length <= x:
        return Outcome.COLLISION
    if x > 0.0:
        return Outcome.NOT_STOP
    if -x <= scenario.road.stop_zone and speed < scenario.road.stop_speed:
        return Outcome.SUCCESS
    if step >= scenario.horizon:
        return Outcome.TIMEOUT
    if agent > 0 and x - length <= positions[agent - 1]:
        return Outcome.REAR_ENDED
    return Outcome.RUNNING


def friction(scenario: Scenario, chance: float, drawn: float) -> float:
    """The friction of a world, given two draws that are uniform in [0, 1)."""
    slippery = scenario.road.slippery
    if slippery is None or chance >= slippery.share:
        return scenario.road.friction
    return slippery.friction[0] + (slippery.friction[1] - slippery.friction[0]) * drawn


def braking(
    scenario: Scenario, position: float, speed: float, steps: int, friction: float | None = None
) -> list[float]:
    """Where a vehicle that brakes fully is after 0, 1, 2, ... steps: the actuator's equations, one by one."""
    vehicle, dt, accel = scenario.vehicle, scenario.dt, 0.0
    grip, most = (friction or scenario.road.friction) * 9.81, vehicle.jerk_limit * dt
    positions = [position]
    for _ in range(steps):
        change = (vehicle.levels[0] - accel) * dt / (vehicle.lag + dt)
        accel = max(-grip, min(grip, accel + max(-most, min(most, change))))
        after = max(speed + accel * dt, 0.0)
        position += (speed + after) / 2 * dt
        accel, speed = (after - speed) / dt, after
        positions.append(position)
    return positions


def feasible(scenario: Scenario, start: tuple[float, float], rears: NDArray[np.float64]) -> bool:
    """Whether an ego that starts at (position, speed) could have stopped at the line behind these rears, step by step.

    Where full braking is hit nobody could have survived; and the line has to be freed early enough to cover a safe gap,
    a car's length and the stop zone at walking pace, as long as there was the time to see it.
    """
    ego = braking(scenario, *start, len(rears) - 1)
    if any(rear <= x for rear, x in zip(rears[1:], ego[1:], strict=True)):
        return False
    queue = scenario.reward.safe_gap + scenario.vehicle.length + scenario.road.stop_zone
    latest = scenario.horizon * scenario.dt - queue / 1.4
    freed = [step * scenario.dt for step, rear in enumerate(rears) if step > 0 and rear > 0.0]
    seen = (len(rears) - 1) * scenario.dt
    return seen <= latest or (len(freed) > 0 and freed[0] <= latest)


def window(scenario: Scenario, step: int) -> int:
    """The window of ``dropout_time`` seconds that a step lies in; 0 is the one that an episode begins with."""
    return step // max(round(scenario.sensor.dropout_time / scenario.dt), 1)


def sensed(
    scenario: Scenario,
    truth: list[dict[str, float]],
    lost: set[int],
    ghosts: list[float | None],
    errors: list[dict[str, float]],
) -> list[dict[str, float]]:
    """What an agent reads at the steps 0, 1, 2, ..., in SI units, given what a perfect sensor reads there.

    In the steps that are ``lost`` the front sensor drops out. ``ghosts`` is how far ahead the one stands that a sensor
    reports at each step. ``errors`` are what a sensor adds at each step to what it reads of each element, in standard
    deviations.
    """
    sensor, read = scenario.sensor, []
    empty = {"d_f": sensor.front_range, "v_f": scenario.road.speed_limit, "a_f": 0.0}
    standing = [{} if ghost is None else {"d_f": ghost, "v_f": 0.0, "a_f": 0.0} for ghost in ghosts]
    seen = [{**true, **ghost} for true, ghost in zip(truth, standing, strict=True)]
    taken = [{**one, **(empty if step in lost else {})} for step, one in enumerate(seen)]
    noise = {"d_f": sensor.noise_distance, "d_d": sensor.noise_distance, "a_e": sensor.noise_accel}
    noise |= {"v_e": sensor.noise_speed, "v_f": sensor.noise_speed, "a_f": sensor.noise_accel}
    for step, error in enumerate(errors):
        shown = dict(taken[max(step - sensor.delay, 0)])
        for symbol, deviation in noise.items():
            shown[symbol] += deviation * error[symbol]
            shown[symbol] = max(shown[symbol], 0.0) if symbol in {"v_e", "d_f", "v_f"} else shown[symbol]
        facts = Facts(shown["v_e"], shown["j_e"], shown["d_d"], shown["d_f"], shown["v_f"], Outcome.RUNNING)
        read.append({**shown, **critical(facts, scenario)})
    return read


def critical(facts: Facts, scenario: Scenario) -> dict[str, float]:
    """The elements that Eq. (dis) gives for what was read, floored and clipped as the page says."""
    a_max, d_0 = scenario.vehicle.max_decel, scenario.reward.safe_gap
    d_fs, d_ds = max((facts.v_e**2 - facts.v_f**2) / (2 * a_max), d_0), facts.v_e**2 / (2 * a_max)
    d_fc, d_dc = facts.d_f - d_fs, facts.d_d - d_ds
    ratios = {"d_fc/d_fs": d_fc / d_fs, "d_dc/d_ds": d_dc / max(d_ds, 0.5)}
    return {"d_fc": d_fc, "d_dc": d_dc, **{symbol: min(max(ratio, -1.0), 10.0) for symbol, ratio in ratios.items()}}
