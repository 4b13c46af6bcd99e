"""Reset of rows: draw the world of the next episode and decide whether it is feasible.

A row's STATUS says how far its reset is: it has BEGUN and nothing is due, its next episode is WAITING, its world is
TO_DRAW, its feasibility is OPEN because the cheap bounds do not decide it, or it is DECIDED.
"""

import numpy as np

from hhrl_envs.arrays import Floats, Keys
from hhrl_envs.simulation.dynamics import drive_agent
from hhrl_envs.simulation.engine import layout as at
from hhrl_envs.simulation.engine.compilation import inner, kernel, spliced, unsigned
from hhrl_envs.simulation.engine.layout import BEGUN, DECIDED, EPISODE, OPEN, SEED, TO_DRAW, WAITING, locate, locate_row
from hhrl_envs.simulation.engine.random_streams import stream
from hhrl_envs.simulation.feasibility import bounds_hold, start_shadow, surely_clears, surely_survives, verdict
from hhrl_envs.simulation.initial_state import draw_world
from hhrl_envs.simulation.outcomes import switch_lines
from hhrl_envs.simulation.traffic import drive_traffic
from hhrl_envs.sub_goals import RUNNING

WORLD = unsigned(0)  # purpose of the stream that a world's own streams come from


@spliced
def settle_row(m: Floats, s: int, r: int, fronts: int, c: Floats) -> None:
    """Decide the feasibility of a row whose world has been drawn, if the bounds can or learned vehicles forbid it."""
    bounded = bounds_hold(m, s, fronts, c) and surely_clears(m, s, fronts, c) and surely_survives(m, s, c)
    decided = c[at.AGENTS] > 1.0 or bounded
    m[r + at.FEASIBLE], m[r + at.STEPS] = 1.0, 0.0
    m[r + at.STATUS] = DECIDED if decided else OPEN


@spliced
def start_agents(m: Floats, s: int, r: int, c: Floats) -> None:
    """Begin the episodes of all agents of a row."""
    m[r + at.STATUS] = BEGUN
    for agent in range(unsigned(c[at.AGENTS])):
        m[s + agent * at.VEHICLE + at.OUTCOME] = RUNNING
        m[s + agent * at.VEHICLE + at.LIVE] = 0.0


@spliced
def reset_due(m: Floats, s: int, r: int, keys: Keys, first: int, c: Floats, special: bool | None, lanes: int) -> int:
    """Reset the rows that are due in a block, whose rows begin at ``first``, and return how many are OPEN."""
    still_open = 0
    i = next_due(m, r, unsigned(0), lanes) if some_due(m, r, lanes) else lanes
    while i < lanes:
        reset_row(m, s + i, r + i, keys, first + i, c, special)
        still_open += m[r + at.STATUS + i] == OPEN
        i = next_due(m, r, i + unsigned(1), lanes)
    return still_open


@inner
def some_due(m: Floats, r: int, lanes: int) -> bool:
    """Return whether any row of record ``r`` is due to begin; mostly none is, and many lanes are asked at a time."""
    due = False
    for i in range(lanes):
        due |= m[r + at.STATUS + i] != BEGUN
    return due


@inner
def next_due(m: Floats, r: int, lane: int, lanes: int) -> int:
    """Return the first lane from ``lane`` on whose row in record ``r`` is due to begin; ``lanes`` if there is none."""
    while (lane < lanes) and (m[r + at.STATUS + lane] == BEGUN):
        lane += unsigned(1)
    return lane


@spliced
def reset_row(m: Floats, s: int, r: int, keys: Keys, row: int, c: Floats, special: bool | None) -> None:
    """Reset one row, whose records plus its lane are ``s`` and ``r``, as far as it can be."""
    if m[r + at.STATUS] == WAITING:
        keys[EPISODE, row] += np.uint64(1)
        m[r + at.ATTEMPT] = 0.0
    if m[r + at.STATUS] <= TO_DRAW:
        world = stream(keys[SEED, row], keys[EPISODE, row], unsigned(m[r + at.ATTEMPT]), WORLD)
        fronts = draw_world(m, s, r, world, keys[EPISODE, row], c, special)
        settle_row(m, s, r, fronts, c)
        if special is not None:
            start_shadow(m, s, r)
    if m[r + at.STATUS] == DECIDED:
        start_agents(m, s, r, c)


@kernel
def decide_rows(m: Floats, c: Floats, special: bool | None, rows: int, low: int, high: int) -> int:
    """Decide the OPEN rows of the blocks from low to high by driving their worlds ahead, many at a time.

    Return the most steps that one of them was driven. Where only feasible worlds are wanted, an infeasible one is to be
    drawn anew.
    """
    trial, tried = np.empty(locate(unsigned(1), c)[1]), np.empty(at.LANES, np.int64)
    lanes, end, longest = 0, min(high * at.LANES, rows), 0
    for row in range(low * at.LANES, end):
        _, r = locate_row(row, c)
        if m[r + at.STATUS] == OPEN:
            copy_row(m, r, trial, unsigned(lanes))
            tried[lanes] = row
            lanes += 1
        if (lanes == at.LANES) | (row == end - 1):
            longest = max(longest, drive_ahead(trial, c, special, unsigned(lanes)))
            for lane in range(lanes):
                note_verdict(m, tried[lane], trial, lane, c)
            lanes = 0
    return longest


@inner
def copy_row(m: Floats, r: int, trial: Floats, lane: int) -> None:
    """Copy the row whose numbers begin at ``r`` to a lane of the only block of ``trial``."""
    for field in range(trial.size // at.STRIDE):
        trial[lane + unsigned(field * at.STRIDE)] = m[r + unsigned(field * at.STRIDE)]


@inner
def note_verdict(m: Floats, row: int, trial: Floats, lane: int, c: Floats) -> None:
    """Take over what was found out about a row in a lane of ``trial``."""
    r = locate_row(row, c)[1]
    feasible = trial[locate_row(lane, c)[1] + at.FEASIBLE]
    again = (c[at.FEASIBLE_ONLY] != 0.0) & (feasible == 0.0)
    m[r + at.FEASIBLE] = feasible
    m[r + at.ATTEMPT] += 1.0 if again else 0.0
    m[r + at.STATUS] = TO_DRAW if again else DECIDED


@inner
def drive_ahead(trial: Floats, c: Floats, special: bool | None, lanes: int) -> int:
    """Drive the first lanes of a block under full braking until the feasibility of every one is decided.

    Return how many steps that took.
    """
    s, r = locate(unsigned(0), c)
    for i in range(lanes):
        trial[s + at.TARGET + i] = c[at.EGO_MIN_ACCEL]
        trial[r + at.FEASIBLE + i] = -1.0
    undecided, steps = lanes > 0, 0
    while undecided:
        undecided = False
        for i in range(lanes):
            if trial[r + at.FEASIBLE + i] < 0.0:
                trial[r + at.FEASIBLE + i] = verdict(trial, s + i, r + i, c)
                undecided |= trial[r + at.FEASIBLE + i] < 0.0
            trial[r + at.STEPS + i] += 1.0
        if undecided:
            switch_lines(trial, s, r, c, lanes)
            drive_traffic(trial, s, c, special, lanes)
            drive_agent(trial, s, c, special, lanes)
            steps += 1
    return steps
