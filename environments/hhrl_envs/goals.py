"""What an episode asks of the ego, and how its active stop-line moves on."""

from enum import IntEnum

from hhrl_envs import layout as at
from hhrl_envs.compiled import Floats, inner, unsigned
from hhrl_envs.layout import APPROACHING, DWELLING, FAR


class Goal(IntEnum):
    """What SUCCESS means: a stop at the last line, reaching the end of the route, or following until the horizon."""

    STOP = 0
    PASS = 1
    FOLLOW = 2


STOP, PASS, FOLLOW = (int(goal) for goal in Goal)


@inner
def switch_signals(m: Floats, first: int, r: int, c: Floats, lanes: int) -> None:
    """Take the line away from every vehicle of the rows whose signal has turned green; who waited there starts anew.

    ``first`` is the ego's record, ``r`` that of the rows.
    """
    for i in range(lanes):
        if m[r + at.STEPS + i] * c[at.DT] >= m[r + at.GREEN_AT + i]:
            for k in range(unsigned(c[at.SLOTS])):
                s = first + k * at.VEHICLE + i
                if m[s + at.PHASE] == DWELLING:
                    m[s + at.STANDING] = 0.0
                    m[s + at.PHASE] = APPROACHING
                m[s + at.LINE] = FAR


@inner
def finish_stops(m: Floats, s: int, c: Floats, lanes: int) -> None:
    """Make the next line active where running agents of record ``s`` have completed a stop at one before the last."""
    zone, slow, last = c[at.STOP_ZONE], c[at.STOP_SPEED], c[at.LAST_LINE]
    for i in range(lanes):
        line = m[s + at.LINE + i]
        d_d = line - m[s + at.POSITION + i]
        stopped = (m[s + at.LIVE + i] != 0.0) & (d_d >= 0.0) & (d_d <= zone) & (m[s + at.SPEED + i] < slow)
        m[s + at.LINE + i] = last if stopped & (line < last) else line


@inner
def switch_lines(m: Floats, first: int, r: int, c: Floats, lanes: int) -> None:
    """Take the line away where a signal has turned green, and make the next one active for agents that have stopped.

    ``first`` is the ego's record, ``r`` that of the rows.
    """
    if c[at.SIGNAL] != 0.0:
        switch_signals(m, first, r, c, lanes)
    if c[at.FIRST_LINE] < c[at.LAST_LINE]:
        for agent in range(unsigned(c[at.AGENTS])):
            finish_stops(m, first + agent * at.VEHICLE, c, lanes)


@inner
def keep_band(m: Floats, s: int, r: int, c: Floats, lanes: int) -> None:
    """Count the steps in which the ego's gap lies within the band: BAND_LOW to BAND_HIGH + BAND_HEADWAY * v_f."""
    if c[at.GOAL] != FOLLOW:
        return
    leader = s + at.VEHICLE
    for i in range(lanes):
        gap = m[leader + at.POSITION + i] - c[at.LENGTH] - m[s + at.POSITION + i]
        widest = c[at.BAND_HIGH] + c[at.BAND_HEADWAY] * m[leader + at.SPEED + i]
        m[r + at.KEPT + i] += 1.0 if (gap >= c[at.BAND_LOW]) & (gap <= widest) else 0.0
