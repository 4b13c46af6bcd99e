"""What an episode asks of the ego, and how its active stop-line moves on."""

from enum import IntEnum

from hhrl_envs import layout
from hhrl_envs.compiled import Floats, Ints, kernel
from hhrl_envs.layout import APPROACHING, DWELLING, FAR


class Goal(IntEnum):
    """What SUCCESS means: a stop at the last line, reaching the end of the route, or following until the horizon."""

    STOP = 0
    PASS = 1
    FOLLOW = 2


STOP, PASS, FOLLOW = (int(goal) for goal in Goal)


@kernel
def switch_signals(state: Floats, rows: Floats, steps: Ints, c: Floats, low: int, high: int) -> None:
    """Take the line away from every vehicle of the rows whose signal has turned green; who waited there starts anew."""
    for i in range(low, high):
        if steps[i] * c[layout.DT] >= rows[layout.GREEN_AT, i]:
            for k in range(state.shape[1]):
                if state[layout.PHASE, k, i] == DWELLING:
                    state[layout.STANDING, k, i] = 0.0
                    state[layout.PHASE, k, i] = APPROACHING
                state[layout.LINE, k, i] = FAR


@kernel
def finish_stops(state: Floats, k: int, c: Floats, low: int, high: int) -> None:
    """Make the next line active where agent ``k`` has completed a stop at one that is not the last."""
    zone, slow, last = c[layout.STOP_ZONE], c[layout.STOP_SPEED], c[layout.LAST_LINE]
    for i in range(low, high):
        line = state[layout.LINE, k, i]
        d_d = line - state[layout.POSITION, k, i]
        stopped = (d_d >= 0.0) & (d_d <= zone) & (state[layout.SPEED, k, i] < slow)
        state[layout.LINE, k, i] = last if stopped & (line < last) else line


@kernel
def keep_band(state: Floats, rows: Floats, c: Floats, low: int, high: int) -> None:
    """Count the steps in which the ego's gap lies within the band: BAND_LOW to BAND_HIGH + BAND_HEADWAY * v_f."""
    for i in range(low, high):
        gap = state[layout.POSITION, 1, i] - c[layout.LENGTH] - state[layout.POSITION, 0, i]
        widest = c[layout.BAND_HIGH] + c[layout.BAND_HEADWAY] * state[layout.SPEED, 1, i]
        rows[layout.KEPT, i] += 1.0 if (gap >= c[layout.BAND_LOW]) & (gap <= widest) else 0.0
