"""The stop-line that is active, and how an episode ends: exclusive and exhaustive outcomes."""

from collections.abc import Callable

from hhrl_envs.arrays import Floats
from hhrl_envs.scenario.scenario import FOLLOW, PASS, STOP
from hhrl_envs.simulation.engine import layout as at
from hhrl_envs.simulation.engine.compilation import in_turn, inlined, inner, unsigned
from hhrl_envs.simulation.engine.layout import APPROACHING, DWELLING, FAR
from hhrl_envs.simulation.sub_goal_kernels import KERNELS
from hhrl_envs.sub_goals import REAR_ENDED, RUNNING, SUB_GOALS, SUCCESS, TIMEOUT


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


def _note_failure_of(k: int) -> Callable[[Floats, int], None]:
    code, failed = float(SUB_GOALS[k].failure), KERNELS[k].failed

    @inlined
    def note_failure(m: Floats, s: int) -> None:
        """Put the failure of sub-goal k into FRESH where it has happened; ``s`` is an agent's record plus lane."""
        otherwise = m[s + at.FRESH]
        m[s + at.FRESH] = code if failed(m, s) else otherwise

    return note_failure


note_failures = in_turn(map(_note_failure_of, reversed(at.FAILURE_ORDER)))  # the last one counts: the lowest code


@inner
def judge(m: Floats, s: int, behind: int, r: int, c: Floats, lanes: int) -> None:
    """Write the outcomes of the agents of record ``s``, after `measure`; an agent that had ended before keeps its own.

    FRESH is the outcome of those that end in this very step, so that an ending is rewarded once. ``behind`` is
    the record of their followers (the same where there are none), ``r`` that of the rows.
    """
    length, zone, slow, horizon = c[at.LENGTH], c[at.STOP_ZONE], c[at.STOP_SPEED], c[at.HORIZON]
    stops, passes, follows = c[at.GOAL] == STOP, c[at.GOAL] == PASS, c[at.GOAL] == FOLLOW
    last, end, needed = c[at.LAST_LINE], c[at.ROUTE_END], c[at.BAND_SHARE] * horizon
    followed_by = behind != s
    for i in range(lanes):
        x, line = m[s + at.POSITION + i], m[s + at.LINE + i]
        late = m[r + at.STEPS + i] >= horizon
        stopped = stops & (line == last) & (line - x <= zone) & (m[s + at.SPEED + i] < slow)
        followed = follows & late & (m[r + at.KEPT + i] >= needed)
        struck = followed_by & (x - length - m[behind + at.POSITION + i] <= 0.0)
        outcome = REAR_ENDED if struck else RUNNING
        outcome = TIMEOUT if late else outcome
        m[s + at.FRESH + i] = SUCCESS if stopped | followed | (passes & (x > end)) else outcome
        note_failures(m, s + i)
        outcome = m[s + at.FRESH + i]
        live, before = m[s + at.LIVE + i] != 0.0, m[s + at.OUTCOME + i]
        m[s + at.FRESH + i] = outcome if live else RUNNING
        m[s + at.OUTCOME + i] = outcome if live else before


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
