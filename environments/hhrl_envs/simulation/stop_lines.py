"""What an episode asks of the ego, and how its active stop-line moves on."""

from hhrl_envs.arrays import Floats
from hhrl_envs.simulation.engine import layout as at
from hhrl_envs.simulation.engine.compilation import inner, unsigned
from hhrl_envs.simulation.engine.layout import APPROACHING, DWELLING, FAR


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
