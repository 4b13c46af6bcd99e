"""Learned front vehicles: driven by an agent until its episode ends, and by nobody or a script afterwards."""

from hhrl_envs.arrays import Floats
from hhrl_envs.scenario.scenario import STOP
from hhrl_envs.simulation.dynamics import drive_agent
from hhrl_envs.simulation.engine import layout as at
from hhrl_envs.simulation.engine.compilation import inner, unsigned
from hhrl_envs.simulation.engine.layout import DWELLING, LEAVING
from hhrl_envs.simulation.traffic import HARDEST_DECEL, drive_slot
from hhrl_envs.sub_goals import NOT_STOP, SUCCESS


@inner
def drive_front(m: Floats, s: int, c: Floats, lanes: int) -> None:
    """Advance the learned front vehicles of record ``s`` by one step.

    One that has succeeded or run the line is handed over to the scripted profile drawn for it. One that collided or was
    struck brakes fully, and the wreck stays.
    """
    one = unsigned(1)
    for i in range(lanes):
        outcome = m[s + at.OUTCOME + i]
        if (outcome == SUCCESS) | (outcome == NOT_STOP):
            if m[s + at.FRESH + i] == outcome:
                hand_over(m, s + i, c)
            drive_on(m, s + i, c)
        else:
            drive_agent(m, s + i, c, one)


@inner
def hand_over(m: Floats, s: int, c: Floats) -> None:
    """Let the vehicle ``s``, a record plus a lane, dwell from now on where it has come to a stand, else drive on."""
    stopped = (c[at.GOAL] == STOP) & (m[s + at.SPEED] < c[at.STOP_SPEED])
    m[s + at.PHASE] = DWELLING if stopped else LEAVING
    m[s + at.SPEED] = 0.0 if stopped else m[s + at.SPEED]
    m[s + at.STANDING] = 0.0


@inner
def drive_on(m: Floats, s: int, c: Floats) -> None:
    """Advance the vehicle ``s``, a record plus a lane, by one scripted step, with a scripted vehicle's brakes.

    It may have been handed over too fast and too near to its leader for any brakes. Then it runs into it: the bound on
    its speed, which assumes that it has always kept its distance, would stop it dead.
    """
    x, v = m[s + at.POSITION], m[s + at.SPEED]
    drive_slot(m, s, c, unsigned(1))
    slowest = v - min(HARDEST_DECEL, c[at.GRIP]) * c[at.DT]
    if m[s + at.SPEED] < slowest:
        m[s + at.POSITION] = x + 0.5 * (v + slowest) * c[at.DT]
        m[s + at.ACCEL] = (slowest - v) * c[at.PER_DT]
        m[s + at.SPEED] = slowest
