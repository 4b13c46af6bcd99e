"""How an episode ends: exclusive and exhaustive outcomes."""

from hhrl_envs.arrays import Floats
from hhrl_envs.scenario.scenario import FOLLOW, PASS, STOP
from hhrl_envs.simulation.engine import layout as at
from hhrl_envs.simulation.engine.compilation import inner
from hhrl_envs.sub_goals import COLLISION, NOT_STOP, REAR_ENDED, RUNNING, SUCCESS, TIMEOUT


@inner
def judge(m: Floats, s: int, behind: int, r: int, c: Floats, lanes: int) -> None:
    """Write the outcomes of the agents of record ``s``; those that had ended before the step keep theirs.

    FRESH is the outcome of those that end in this very step, so that an ending is rewarded once. ``behind`` is
    the record of their followers (the same where there are none), ``r`` that of the rows.
    """
    length, zone, slow, horizon = c[at.LENGTH], c[at.STOP_ZONE], c[at.STOP_SPEED], c[at.HORIZON]
    stops, passes, follows = c[at.GOAL] == STOP, c[at.GOAL] == PASS, c[at.GOAL] == FOLLOW
    last, end, needed = c[at.LAST_LINE], c[at.ROUTE_END], c[at.BAND_SHARE] * horizon
    leader, followed_by = s + at.VEHICLE, behind != s
    for i in range(lanes):
        x, line = m[s + at.POSITION + i], m[s + at.LINE + i]
        d_f = m[leader + at.POSITION + i] - length - x
        late = m[r + at.STEPS + i] >= horizon
        stopped = stops & (line == last) & (line - x <= zone) & (m[s + at.SPEED + i] < slow)
        followed = follows & late & (m[r + at.KEPT + i] >= needed)
        struck = followed_by & (x - length - m[behind + at.POSITION + i] <= 0.0)
        outcome = REAR_ENDED if struck else RUNNING
        outcome = TIMEOUT if late else outcome
        outcome = SUCCESS if stopped | followed | (passes & (x > end)) else outcome
        outcome = NOT_STOP if x > line else outcome
        outcome = COLLISION if d_f <= 0.0 else outcome
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
