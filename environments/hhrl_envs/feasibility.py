"""Whether any ego could succeed in an episode."""

import numpy as np

from hhrl_envs import layout
from hhrl_envs.compiled import Floats, as_row, kernel
from hhrl_envs.dynamics import drive_agent
from hhrl_envs.goals import FOLLOW, PASS, switch_signals
from hhrl_envs.layout import FAR
from hhrl_envs.streams import stream
from hhrl_envs.traffic import drive_slot
from hhrl_envs.worlds import draw_world

MAX_ATTEMPTS = 1000


@kernel
def is_feasible(state: Floats, profile: Floats, rows: Floats, i: int, c: Floats) -> bool:
    """Return whether some ego can succeed in row ``i``, which stands at its start.

    Scripted vehicles never react to the ego behind them, so full braking minimises the ego's position at every time:
    if it collides, the collision is unavoidable. Success also needs the nearest front vehicle to leave the goal's place
    early enough to cover the last metres of a queue at walking pace before the time limit.
    """
    world, drivers, row = state[:, :, i : i + 1].copy(), profile[:, :, i : i + 1].copy(), rows[:, i : i + 1].copy()
    brake = np.full(1, c[layout.EGO_MIN_ACCEL])
    steps = np.zeros(1, np.int64)
    place = c[layout.ROUTE_END] if c[layout.GOAL] == PASS else c[layout.LAST_LINE]
    place = -FAR if c[layout.GOAL] == FOLLOW else place
    while steps[0] < c[layout.HORIZON]:
        rear = world[layout.POSITION, 1, 0] - c[layout.LENGTH]
        if rear <= world[layout.POSITION, 0, 0]:
            return False
        if (rear > place) & (world[layout.SPEED, 0, 0] == 0.0):
            return bool(steps[0] * c[layout.DT] <= c[layout.CLEAR_BY])
        steps[0] += 1
        if c[layout.SIGNAL] != 0.0:
            switch_signals(world, row, steps, c, as_row(0), as_row(1))
        for k in range(world.shape[1] - 2, 0, -1):
            drive_slot(world, drivers, k, c, as_row(0), as_row(1))
        drive_agent(world, brake, 0, c, as_row(0), as_row(1))
    return False


@kernel
def begin(
    state: Floats, profile: Floats, rows: Floats, i: int, seed: np.uint64, episode: np.uint64, feasible_only: bool,
    c: Floats, counts: Floats, families: Floats,
) -> bool:  # fmt: skip
    """Put row ``i`` at the start of its episode and return whether the episode is feasible.

    With ``feasible_only`` worlds are drawn anew, each attempt from streams of its own, until one is.
    """
    for attempt in range(MAX_ATTEMPTS):
        key = stream(seed, episode, attempt, 0)
        draw_world(state, profile, rows, i, key, episode, c, counts, families)
        feasible = is_feasible(state, profile, rows, i, c)
        if feasible or not feasible_only:
            return feasible
    return False
