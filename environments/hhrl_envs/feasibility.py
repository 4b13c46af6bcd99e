"""Whether any ego could succeed in an episode.

Scripted vehicles never react to the ego behind them, so full braking minimises the ego's position at every time: if it
collides, the collision is unavoidable. Success also needs the nearest front vehicle to leave the goal's place early
enough to cover the last metres of a queue at walking pace before the time limit. Both are decided by driving the world
ahead; where cheap bounds already decide, the drive is shortened or left out.
"""

from math import sqrt

import numpy as np

from hhrl_envs import layout
from hhrl_envs.compiled import Floats, as_row, kernel
from hhrl_envs.dynamics import drive_agent
from hhrl_envs.goals import FOLLOW, PASS, STOP, switch_signals
from hhrl_envs.layout import FAR
from hhrl_envs.traffic import drive_slot

FIRST, AFTER = as_row(0), as_row(1)  # the only row of a trial
SELDOM = 500.0  # m; slow-downs this far apart happen once before the line


@kernel
def braking_place(state: Floats, i: int, c: Floats) -> float:
    """Return the position at which the ego of row ``i`` stands after full braking."""
    ego, brake = np.zeros((layout.STATE_SIZE, 1, 1)), np.full(1, c[layout.EGO_MIN_ACCEL])
    ego[layout.POSITION, 0, 0], ego[layout.SPEED, 0, 0] = state[layout.POSITION, 0, i], state[layout.SPEED, 0, i]
    while ego[layout.SPEED, 0, 0] > 0.0:
        drive_agent(ego, brake, 0, c, FIRST, AFTER)
    return float(ego[layout.POSITION, 0, 0])


@kernel
def latest_clearing(state: Floats, profile: Floats, fronts: int, i: int, c: Floats) -> float:
    """Return a time in seconds by which the front vehicles of row ``i`` have surely left the only line behind them.

    Vehicle after vehicle, from the front: to arrive takes at most one and a half times the free drive and two seconds;
    then, once its leader has left, it moves up, dwells and leaves, with a start delay before each and a slow-down.
    """
    free = 0.0
    for k in range(fronts, 0, -1):
        distance = c[layout.LAST_LINE] + c[layout.LENGTH] - state[layout.POSITION, k, i]
        arrival = 2.0 + 1.5 * max(distance, 0.0) / profile[layout.DESIRED_SPEED, k, i]
        moving_up = 1.0 + 5.0 * sqrt(1.0 / profile[layout.MAX_ACCEL, k, i])
        pauses = profile[layout.DWELL, k, i] + 2.0 * profile[layout.START_DELAY, k, i] + profile[layout.SLOW_TIME, k, i]
        free = max(free, arrival) + moving_up + pauses
    return free


@kernel
def surely_clears(state: Floats, profile: Floats, fronts: int, i: int, c: Floats) -> bool:
    """Return True where ``latest_clearing`` holds and is early enough; False says nothing."""
    holds = (c[layout.GOAL] == STOP) & (c[layout.FIRST_LINE] == c[layout.LAST_LINE])
    for k in range(1, fronts + 1):
        holds &= profile[layout.SLOW_EVERY, k, i] >= SELDOM
    return bool(holds and latest_clearing(state, profile, fronts, i, c) <= c[layout.CLEAR_BY])


@kernel
def drive_ahead(state: Floats, profile: Floats, rows: Floats, place: float, c: Floats) -> bool:
    """Return whether full braking survives and the nearest vehicle has left ``place`` in time; uses up a trial row."""
    brake, steps = np.full(1, c[layout.EGO_MIN_ACCEL]), np.zeros(1, np.int64)
    while steps[0] < c[layout.HORIZON]:
        rear = state[layout.POSITION, 1, 0] - c[layout.LENGTH]
        if rear <= state[layout.POSITION, 0, 0]:
            return False
        if (rear > place) & (state[layout.SPEED, 0, 0] == 0.0):
            return bool(steps[0] * c[layout.DT] <= c[layout.CLEAR_BY])
        steps[0] += 1
        if c[layout.SIGNAL] != 0.0:
            switch_signals(state, rows, steps, c, FIRST, AFTER)
        for k in range(state.shape[1] - 2, 0, -1):
            drive_slot(state, profile, k, c, FIRST, AFTER)
        drive_agent(state, brake, 0, c, FIRST, AFTER)
    return False


@kernel
def is_feasible(state: Floats, profile: Floats, rows: Floats, fronts: int, i: int, c: Floats) -> bool:
    """Return whether some ego can succeed in row ``i``, which stands at its start with ``fronts`` front vehicles."""
    clears = (c[layout.GOAL] == FOLLOW) or surely_clears(state, profile, fronts, i, c)
    if clears and braking_place(state, i, c) < state[layout.POSITION, 1, i] - c[layout.LENGTH]:
        return True
    slots = state.shape[1]
    trial, drivers = np.empty((layout.STATE_SIZE, slots, 1)), np.empty((layout.PROFILE_SIZE, slots, 1))
    row = np.empty((layout.ROW_SIZE, 1))
    for k in range(slots):
        for field in range(layout.STATE_SIZE):
            trial[field, k, 0] = state[field, k, i]
        for field in range(layout.PROFILE_SIZE):
            drivers[field, k, 0] = profile[field, k, i]
    for field in range(layout.ROW_SIZE):
        row[field, 0] = rows[field, i]
    place = c[layout.ROUTE_END] if c[layout.GOAL] == PASS else c[layout.LAST_LINE]
    return drive_ahead(trial, drivers, row, -FAR if clears else place, c)
