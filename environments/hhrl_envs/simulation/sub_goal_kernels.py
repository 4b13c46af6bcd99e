"""What is particular to one sub-goal in compiled code: what it measures, and what its failure is and costs.

Each sub-goal has five functions and says within which bounds its elements lie. In those functions ``m[s + FIELD]`` is a
number of the agent whose record plus lane is ``s``; see ``engine.layout``.
"""

from collections.abc import Callable, Mapping
from typing import NamedTuple

from hhrl_envs.arrays import Floats
from hhrl_envs.scenario.profiles import Range
from hhrl_envs.scenario.scenario import Scenario
from hhrl_envs.simulation.engine import layout as at
from hhrl_envs.simulation.engine.compilation import inner, spliced
from hhrl_envs.simulation.initial_state import abruptest_stop
from hhrl_envs.simulation.traffic import HARDEST_DECEL, fastest_front, quickest_start
from hhrl_envs.sub_goals import SUB_GOALS, Option

MIN_STOPPING_DISTANCE = 0.5  # m; floor of d_ds where it is a denominator
RATIO_LOW, RATIO_HIGH = -1.0, 10.0

D_F, V_F, A_F, D_FC, FC_RATIO = map(at.measured, ("d_f", "v_f", "a_f", "d_fc", "d_fc/d_fs"))
D_D, D_DC, DC_RATIO = map(at.measured, ("d_d", "d_dc", "d_dc/d_ds"))


class Motion(NamedTuple):
    """How an agent may move at most, as far as bounds of elements depend on it.

    Attributes:
        overshoot: the metres that it may be past its line.
        safety: the largest safety distance in metres.
    """

    overshoot: float
    safety: float


class Kernels(NamedTuple):
    """The functions of one sub-goal.

    Attributes:
        measure: ``(m, s, c, lanes)`` writes all of its elements for the agents of record ``s``.
        safety: ``(m, s, c)`` returns its safety distance d_s as it is, never floored.
        derive: ``(m, s, c)`` writes its critical distance and ratio anew, from elements that noise has changed.
        failed: ``(m, s)`` returns whether its failure has happened.
        penalty: ``(m, s, sigma_3)`` returns what its failure costs, at most 0.
        bounds: the least and the largest value of its elements, with sensor noise, in its own order.
    """

    measure: Callable[[Floats, int, Floats, int], None]
    safety: Callable[[Floats, int, Floats], float]
    derive: Callable[[Floats, int, Floats], None]
    failed: Callable[[Floats, int], bool]
    penalty: Callable[[Floats, int, float], float]
    bounds: Callable[[Scenario, Motion], tuple[Range, ...]]


@inner
def stopping_distance(v_e: float, per_twice_decel: float) -> float:
    """Return d_ds: Eq. (dis)."""
    return v_e * v_e * per_twice_decel


@inner
def stop_distances(v_e: float, d_d: float, per_twice_decel: float) -> tuple[float, float]:
    """Return d_dc and d_dc/d_ds, its d_ds floored and the ratio clipped to [-1, 10]: Eq. (dis)."""
    d_ds = stopping_distance(v_e, per_twice_decel)
    d_dc = d_d - d_ds
    return d_dc, min(max(d_dc / max(d_ds, MIN_STOPPING_DISTANCE), RATIO_LOW), RATIO_HIGH)


@inner
def measure_stop(m: Floats, s: int, c: Floats, lanes: int) -> None:
    """Measure the distance to the active stop-line; one out of range shows as the range."""
    line_range, per_twice_decel = c[at.LINE_RANGE], c[at.PER_TWICE_DECEL]
    for i in range(lanes):
        d_d = min(m[s + at.LINE + i] - m[s + at.POSITION + i], line_range)
        d_dc, ratio = stop_distances(m[s + at.SPEED + i], d_d, per_twice_decel)
        m[s + D_D + i] = d_d
        m[s + D_DC + i] = d_dc
        m[s + DC_RATIO + i] = ratio


@spliced
def safety_stop(m: Floats, s: int, c: Floats) -> float:
    """Return d_ds."""
    return stopping_distance(m[s + at.V_E], c[at.PER_TWICE_DECEL])


@inner
def derive_stop(m: Floats, s: int, c: Floats) -> None:
    """Compute d_dc and d_dc/d_ds from the measured elements."""
    m[s + D_DC], m[s + DC_RATIO] = stop_distances(m[s + at.V_E], m[s + D_D], c[at.PER_TWICE_DECEL])


@spliced
def failed_stop(m: Floats, s: int) -> bool:
    """Return whether the front bumper has passed the active line."""
    return bool(m[s + D_D] < 0.0)


@spliced
def penalty_stop(m: Floats, s: int, sigma_3: float) -> float:  # noqa: ARG001
    """Return -v_e^2."""
    speed = m[s + at.V_E]
    return float(-speed * speed)


def bounds_stop(scenario: Scenario, motion: Motion) -> tuple[Range, ...]:
    """Return the bounds of d_d, d_dc and d_dc/d_ds."""
    noise = 6.0 * scenario.sensor.noise_distance
    low, high = -motion.overshoot - noise, max(scenario.road.start_distance[1], scenario.sensor.line_range) + noise
    return (low, high), (low - motion.safety, high), (RATIO_LOW, RATIO_HIGH)


@inner
def following_distance(v_e: float, v_f: float, per_twice_decel: float, safe_gap: float) -> float:
    """Return d_fs: Eq. (dis)."""
    return max((v_e * v_e - v_f * v_f) * per_twice_decel, safe_gap)


@inner
def follow_distances(
    v_e: float, d_f: float, v_f: float, per_twice_decel: float, safe_gap: float
) -> tuple[float, float]:
    """Return d_fc and d_fc/d_fs, clipped to [-1, 10]: Eq. (dis)."""
    d_fs = following_distance(v_e, v_f, per_twice_decel, safe_gap)
    d_fc = d_f - d_fs
    return d_fc, min(max(d_fc / d_fs, RATIO_LOW), RATIO_HIGH)


@inner
def measure_follow(m: Floats, s: int, c: Floats, lanes: int) -> None:
    """Measure the front vehicle, which lies in the next record; one out of range shows as an empty road."""
    length, reach, limit, leader = c[at.LENGTH], c[at.FRONT_RANGE], c[at.SPEED_LIMIT], s + at.VEHICLE
    per_twice_decel, safe_gap = c[at.PER_TWICE_DECEL], c[at.SAFE_GAP]
    for i in range(lanes):
        ahead = m[leader + at.POSITION + i] - length - m[s + at.POSITION + i]
        v_f, a_f = m[leader + at.SPEED + i], m[leader + at.ACCEL + i]
        seen = ahead <= reach
        d_f, v_f, a_f = min(max(ahead, 0.0), reach), v_f if seen else limit, a_f if seen else 0.0
        d_fc, ratio = follow_distances(m[s + at.SPEED + i], d_f, v_f, per_twice_decel, safe_gap)
        m[s + D_F + i] = d_f
        m[s + V_F + i] = v_f
        m[s + A_F + i] = a_f
        m[s + D_FC + i] = d_fc
        m[s + FC_RATIO + i] = ratio


@inner
def lose_front(m: Floats, s: int, c: Floats) -> None:
    """Measure an empty road instead of the front vehicle; what is derived from that is not written."""
    m[s + D_F], m[s + V_F], m[s + A_F] = c[at.FRONT_RANGE], c[at.SPEED_LIMIT], 0.0


@inner
def meet_ghost(m: Floats, s: int, place: float) -> None:
    """Measure a vehicle that stands at a place instead of the front vehicle; nothing is derived from that yet."""
    m[s + D_F], m[s + V_F], m[s + A_F] = place - m[s + at.POSITION], 0.0, 0.0


@spliced
def safety_follow(m: Floats, s: int, c: Floats) -> float:
    """Return d_fs."""
    return following_distance(m[s + at.V_E], m[s + V_F], c[at.PER_TWICE_DECEL], c[at.SAFE_GAP])


@inner
def derive_follow(m: Floats, s: int, c: Floats) -> None:
    """Compute d_fc and d_fc/d_fs from the measured elements."""
    per_twice_decel, safe_gap = c[at.PER_TWICE_DECEL], c[at.SAFE_GAP]
    m[s + D_FC], m[s + FC_RATIO] = follow_distances(m[s + at.V_E], m[s + D_F], m[s + V_F], per_twice_decel, safe_gap)


@spliced
def failed_follow(m: Floats, s: int) -> bool:
    """Return whether the front vehicle has been touched."""
    return bool(m[s + D_F] <= 0.0)


@spliced
def penalty_follow(m: Floats, s: int, sigma_3: float) -> float:  # noqa: ARG001
    """Return -sigma_3."""
    return -sigma_3


def bounds_follow(scenario: Scenario, motion: Motion) -> tuple[Range, ...]:
    """Return the bounds of d_f, v_f, a_f, d_fc and d_fc/d_fs."""
    sensor = scenario.sensor
    speed, accel, distance = (6.0 * noise for noise in (sensor.noise_speed, sensor.noise_accel, sensor.noise_distance))
    far, usual = sensor.front_range + distance, 2.0 * HARDEST_DECEL
    accels = -max(usual, abruptest_stop(scenario)) - accel, max(usual, quickest_start(scenario)) + accel
    speeds = (0.0, fastest_front(scenario) + speed)
    return (0.0, far), speeds, accels, (-motion.safety, far), (RATIO_LOW, RATIO_HIGH)


_BY_OPTION: Mapping[Option, Kernels] = {
    Option.SSL: Kernels(measure_stop, safety_stop, derive_stop, failed_stop, penalty_stop, bounds_stop),
    Option.FFV: Kernels(measure_follow, safety_follow, derive_follow, failed_follow, penalty_follow, bounds_follow),
}
KERNELS = tuple(_BY_OPTION[goal.option] for goal in SUB_GOALS)
"""The functions of every sub-goal, in their order."""
