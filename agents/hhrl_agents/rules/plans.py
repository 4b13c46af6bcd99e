"""Plans of an ego that knows how its front vehicle will drive, compiled.

A plan brakes until a step, the launch, and stands where that takes longer; then it drives on as fast as its caps allow
and stops at the near end of the stop zone. Of all trajectories that stop there at the same time, this one is the
furthest behind at every time before: whoever brakes less at first, or drives on earlier, is ahead of it. So where it
touches the front vehicle, all of them do, and a later launch is never further ahead. The earliest launch that touches
nothing, found by bisection, therefore gives the quickest stop, but for the actuator's lag and for what steps of time
and discrete levels leave no choice about.
"""

from math import inf
from typing import NamedTuple

import numpy as np

from hhrl_envs.arrays import Codes, Floats, Ints
from hhrl_envs.simulation.dynamics import actuate
from hhrl_envs.simulation.engine.compilation import inner, kernel

HAIR = 1e-6  # m; more than rounding takes
FOLLOW_SPEED_GAIN, FOLLOW_GAP_GAIN = 1.0, 0.25  # 1/s and 1/s^2: the gap settles without swinging
FOLLOW_SLACK = 1.0  # m; the room for what discrete levels cannot do


class Body(NamedTuple):
    """How an ego moves: the simulator's numbers; see ``hhrl_envs.simulation.dynamics``.

    The ``grip`` is that of a world's road; see `of_world`.
    """

    dt: float
    gain: float
    most: float
    limit: float
    grip: float = inf


MOST_MOVES = 10_000_000
"""Steps that the search for one plan may drive ahead in all; where it takes more, no plan is found."""


class Caps(NamedTuple):
    """The strongest levels that a plan uses, as indices, and the metres within which their brake always stops.

    This ``reach`` is a world's, as its road's grip is; see `of_world`.
    """

    brake: int
    throttle: int
    reach: float = inf


class Goals(NamedTuple):
    """How a leg of a plan ends: in a stop within ``zone`` metres before its line, below ``slow`` m/s.

    The plan aims at most ``tolerance`` metres beyond the near end of that zone. If ``passing``, the last leg ends
    beyond its line instead, at any speed.
    """

    zone: float
    slow: float
    tolerance: float
    passing: bool


Motion = tuple[float, float, float]
"""Position [m], speed [m/s] and acceleration [m/s^2]."""


@inner
def drive(motion: Motion, target: float, body: Body) -> Motion:
    """Return the motion a step later, with this target acceleration."""
    x, speed, accel = motion
    wanted = actuate(accel, target, body.gain, body.most, body.grip)
    moved = min(max(speed + wanted * body.dt, 0.0), body.limit)
    return x + 0.5 * (speed + moved) * body.dt, moved, (moved - speed) / body.dt


@inner
def stop(motion: Motion, brake: float, body: Body, left: Ints) -> float:
    """Return the position at which an ego that brakes from now on stands; infinite where no moves are ``left``."""
    while motion[1] > 0.0:
        if left[0] <= 0:
            return inf
        left[0] -= 1
        motion = drive(motion, brake, body)
    return motion[0]


@inner
def braking_reach(accel: float, brake: float, body: Body) -> float:
    """Return the metres that an ego at the speed limit, with this acceleration, takes to stop."""
    return stop((0.0, body.limit, accel), brake, body, np.full(1, MOST_MOVES))


@inner
def of_world(body: Body, caps: Caps, levels: Floats, grip: float) -> tuple[Body, Caps]:
    """Return how an ego moves on the road of one world, and the reach of its brake there."""
    own = Body(body.dt, body.gain, body.most, body.limit, grip)
    return own, Caps(caps.brake, caps.throttle, braking_reach(levels[caps.throttle], levels[caps.brake], own))


@inner
def can_stop(motion: Motion, aim: float, brake: float, reach: float, body: Body, left: Ints) -> bool:
    """Return whether an ego that brakes from now on stands no further than ``aim``."""
    return motion[0] + reach <= aim or stop(motion, brake, body, left) <= aim


@inner
def approach(motion: Motion, line: float, levels: Floats, caps: Caps, goals: Goals, body: Body, left: Ints) -> int:
    """Return the level that stops an ego soonest before a line.

    It is the brake once that stops within the zone; until then the highest level after which it still can. A lower
    level never takes it further, so that one is found by bisection.
    """
    brake, near = levels[caps.brake], line - goals.zone + HAIR
    if motion[0] + caps.reach >= near and stop(motion, brake, body, left) >= near:
        return caps.brake
    aim, able, unable = near + goals.tolerance, caps.brake, caps.throttle + 1
    level = caps.throttle
    while unable - able > 1:
        if can_stop(drive(motion, levels[level], body), aim, brake, caps.reach, body, left):
            able = level
        else:
            unable = level
        level = (able + unable) // 2
    return able


@inner
def launch_at(
    launch: int, first: int, motion: Motion, line: float, passing: bool, ceiling: Floats, levels: Floats, caps: Caps,
    goals: Goals, body: Body, left: Ints, actions: Codes,
) -> tuple[int, Motion]:  # fmt: skip
    """Drive to a line from the step ``first`` on, braking until ``launch``, and write the actions.

    Return the number of steps done in all, and the motion at the end. It is -1 where the ego comes to the ``ceiling``,
    the positions that it may not reach, float64 [horizon + 1], and horizon + 1 where the time is over before.
    """
    t, horizon = first, actions.size
    while t < horizon and left[0] > 0:
        left[0] -= 1
        if t < launch and motion[1] == 0.0 and motion[2] == 0.0:
            standing = min(launch, horizon)
            actions[t:standing] = caps.brake
            t = standing
            continue
        action = caps.brake
        if t >= launch:
            action = caps.throttle if passing else approach(motion, line, levels, caps, goals, body, left)
        actions[t] = action
        motion = drive(motion, levels[action], body)
        t += 1
        if motion[0] >= ceiling[t]:
            return -1, motion
        stopped = line - goals.zone <= motion[0] <= line and motion[1] < goals.slow
        if motion[0] > line if passing else stopped:
            return t, motion
    return horizon + 1, motion


@inner
def leg(
    first: int, motion: Motion, line: float, passing: bool, ceiling: Floats, levels: Floats, caps: Caps, goals: Goals,
    body: Body, left: Ints, actions: Codes,
) -> tuple[int, Motion]:  # fmt: skip
    """Drive to a line as `launch_at` does, with the earliest launch that does not come to the ceiling."""
    too_early, early_enough = first - 1, actions.size
    launch = first
    while early_enough - too_early > 1:
        done, _ = launch_at(launch, first, motion, line, passing, ceiling, levels, caps, goals, body, left, actions)
        if done < 0:
            too_early = launch
        else:
            early_enough = launch
        launch = (too_early + early_enough) // 2
    return launch_at(early_enough, first, motion, line, passing, ceiling, levels, caps, goals, body, left, actions)


@kernel
def plan_rows(
    motions: Floats, ceilings: Floats, lines: Floats, levels: Floats, caps: Caps, goals: Goals, body: Body,
    grips: Floats, steps: Ints, actions: Codes,
) -> None:  # fmt: skip
    """Plan the quickest way along all ``lines`` for every row of ``motions``, float64 [B, 4].

    ``ceilings``, float64 [B, horizon + 1], are the positions that an ego may not reach, ``grips``, float64
    [B], those of the roads. ``steps``, int64 [B], becomes the steps until the end, or 0 where no plan comes there in
    time; ``actions``, int8 [B, horizon], the levels.
    """
    for row in range(steps.size):
        own, limits = of_world(body, caps, levels, grips[row])
        motion, done, left = (motions[row, 0], motions[row, 1], motions[row, 2]), 0, np.full(1, MOST_MOVES)
        for place in range(lines.size):
            if 0 <= done <= actions.shape[1]:
                passing = goals.passing and place == lines.size - 1
                done, motion = leg(
                    done, motion, lines[place], passing, ceilings[row], levels, limits, goals, own, left, actions[row]
                )
        steps[row] = done if 0 < done <= actions.shape[1] and left[0] > 0 else 0


@inner
def follow(motion: Motion, gap: float, now: float, then: float, body: Body) -> float:
    """Return the acceleration that brings an ego softly to ``gap`` metres below a ceiling, now and a step later."""
    speed_error = (then - now) / body.dt - motion[1]
    return FOLLOW_SPEED_GAIN * speed_error + FOLLOW_GAP_GAIN * (now - motion[0] - gap - FOLLOW_SLACK)


@inner
def stays_behind(
    motion: Motion, t: int, gap: float, ceiling: Floats, brake: float, body: Body, left: Ints
) -> bool:  # fmt: skip
    """Return whether an ego that brakes from the step ``t`` on stands without coming within ``gap`` of the ceiling."""
    while t < ceiling.size and motion[0] + gap < ceiling[t] and left[0] > 0:
        if motion[1] == 0.0:
            return True
        left[0] -= 1
        motion = drive(motion, brake, body)
        t += 1
    return t == ceiling.size


@kernel
def follow_rows(
    motions: Floats, ceilings: Floats, gap: float, levels: Floats, caps: Caps, body: Body, grips: Floats, steps: Ints,
    actions: Codes,
) -> None:  # fmt: skip
    """Plan to drive up to ``gap`` metres below the ceilings and keep there until the horizon; see `plan_rows`.

    Every step takes the highest level, but for the strongest brake, that lies no more than half a level above what
    `follow` asks for and after which braking still keeps the gap; the level next to that brake counts as
    asked for. Where there is none it takes the strongest brake. A plan that comes to a ceiling all the same has 0
    ``steps``.
    """
    for row in range(steps.size):
        motion, left = (motions[row, 0], motions[row, 1], motions[row, 2]), np.full(1, MOST_MOVES)
        own, _ = of_world(body, caps, levels, grips[row])
        steps[row] = actions.shape[1]
        for t in range(actions.shape[1]):
            chosen = caps.brake
            wanted = follow(motion, gap, ceilings[row, t], ceilings[row, t + 1], own)
            for level in range(caps.throttle, caps.brake, -1):
                moved = drive(motion, levels[level], own)
                near = level == caps.brake + 1 or 0.5 * (levels[level] + levels[level - 1]) <= wanted
                if near and stays_behind(moved, t + 1, gap, ceilings[row], levels[caps.brake], own, left):
                    chosen = level
                    break
            actions[row, t] = chosen
            motion = drive(motion, levels[chosen], own)
            if motion[0] >= ceilings[row, t + 1] or left[0] <= 0:
                steps[row] = 0
                break
