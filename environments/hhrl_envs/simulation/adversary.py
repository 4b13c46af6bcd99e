"""Front vehicles that are trained to make the ego fail: their limits, their outcomes and their rewards."""

from hhrl_envs.arrays import Floats
from hhrl_envs.simulation.engine import layout as at
from hhrl_envs.simulation.engine.compilation import inner, unsigned
from hhrl_envs.simulation.engine.layout import FAR
from hhrl_envs.sub_goals import COLLISION, FOILED, RUNNING, SUCCESS


@inner
def restrain(m: Floats, s: int, c: Floats, lanes: int) -> None:
    """Keep the adversaries of record ``s`` within human limits, as long as they are running: a wreck stays.

    They brake no harder than HARDEST_BRAKE, and once they have stood for PATIENCE seconds in all they only speed up.
    The line does not bind them: once they have passed it there is none.
    """
    hardest, patience, throttle = -c[at.HARDEST_BRAKE], c[at.PATIENCE], c[at.THROTTLE]
    for i in range(lanes):
        live, target = m[s + at.LIVE + i] != 0.0, m[s + at.TARGET + i]
        standing = m[s + at.STANDING + i] + (c[at.DT] if m[s + at.SPEED + i] == 0.0 else 0.0)
        m[s + at.STANDING + i] = standing if live else m[s + at.STANDING + i]
        restrained = throttle if standing > patience else max(target, hardest)
        m[s + at.TARGET + i] = restrained if live else target
        passed = live & (m[s + at.POSITION + i] > m[s + at.LINE + i])
        m[s + at.LINE + i] = FAR if passed else m[s + at.LINE + i]


@inner
def judge_adversary(m: Floats, ego: int, r: int, c: Floats, lanes: int) -> None:
    """Write the outcomes of the adversaries, if there are any, from those of the egos of record ``ego``.

    A collision of its own ends an adversary's episode as any other; else it ends with the ego's.
    """
    s = ego + at.VEHICLE
    if c[at.ADVERSARY] == 0.0:
        return
    for i in range(lanes):
        fresh, own = m[ego + at.FRESH + i], m[s + at.FRESH + i]
        failed = (fresh != RUNNING) & (fresh != SUCCESS)
        ending = SUCCESS if failed & (m[r + at.FEASIBLE + i] != 0.0) else FOILED
        outcome = COLLISION if own == COLLISION else (RUNNING if fresh == RUNNING else ending)
        live = m[s + at.LIVE + i] != 0.0
        m[s + at.FRESH + i] = outcome if live else RUNNING
        m[s + at.OUTCOME + i] = outcome if live else m[s + at.OUTCOME + i]


@inner
def reward_adversary(m: Floats, ego: int, c: Floats, lanes: int) -> None:
    """Write the rewards of the adversaries, if there are any, whose TIME, UNSMOOTH and COLLISION are written already.

    SUCCESS is +sigma_4 if the ego failed although it need not have, and -sigma_4 otherwise; also if the adversary has
    collided itself, or that would be its cheapest way out. There are no sub-goals: r^option is TIME + SUCCESS, and
    r^action is r^task, whatever the option. ``ego`` is the egos' record.
    """
    s = ego + at.VEHICLE
    if c[at.ADVERSARY] == 0.0:
        return
    for i in range(lanes):
        fresh = m[s + at.FRESH + i]
        lost = (fresh == FOILED) | (fresh == COLLISION)
        success = c[at.SIGMA_4] if fresh == SUCCESS else (-c[at.SIGMA_4] if lost else 0.0)
        m[s + at.SUCCESS + i] = success
        sr = m[s + at.TIME + i] + success
        task = sr + m[s + at.UNSMOOTH + i]
        for k in range(at.GOALS):
            field = unsigned(k * at.STRIDE) + i
            m[s + at.UNSAFE[0] + field] = 0.0
            task += m[s + at.FAILURES[0] + field]
        m[s + at.TASK + i] = task
        for k in range(at.GOALS):
            field = unsigned(k * at.STRIDE) + i
            m[s + at.OPTION[0] + field] = sr
            m[s + at.ACTION[0] + field] = task
