"""How an episode ends: exclusive and exhaustive outcomes."""

from enum import IntEnum

from hhrl_envs import layout
from hhrl_envs.compiled import Codes, Floats, Ints, kernel


class Outcome(IntEnum):
    """The state of an episode. COLLISION, NOT_STOP, SUCCESS and REAR_ENDED terminate it, TIMEOUT truncates it.

    Where several hold in one step the earlier one in this list counts. REAR_ENDED befalls controlled front vehicles
    only.
    """

    RUNNING = 0
    COLLISION = 1
    NOT_STOP = 2
    SUCCESS = 3
    TIMEOUT = 4
    REAR_ENDED = 5


RUNNING, COLLISION, NOT_STOP, SUCCESS, TIMEOUT = (
    int(outcome) for outcome in (Outcome.RUNNING, Outcome.COLLISION, Outcome.NOT_STOP, Outcome.SUCCESS, Outcome.TIMEOUT)
)


@kernel
def judge(state: Floats, steps: Ints, ended: Codes, fresh: Codes, c: Floats, rows: int) -> None:
    """Write this step's outcome of every running row into ``fresh`` and, if it ended, into ``ended`` (int8 [B] both).

    ``fresh`` is RUNNING for rows that had ended before, so that an ending is rewarded once.
    """
    length, zone, slow, horizon = c[layout.LENGTH], c[layout.STOP_ZONE], c[layout.STOP_SPEED], c[layout.HORIZON]
    for i in range(rows):
        d_d = -state[layout.POSITION, 0, i]
        d_f = state[layout.POSITION, 1, i] - length - state[layout.POSITION, 0, i]
        outcome = TIMEOUT if steps[i] >= horizon else RUNNING
        outcome = SUCCESS if (d_d <= zone) & (state[layout.SPEED, 0, i] < slow) else outcome
        outcome = NOT_STOP if d_d < 0.0 else outcome
        outcome = COLLISION if d_f <= 0.0 else outcome
        running = ended[i] == RUNNING
        fresh[i] = outcome if running else RUNNING
        ended[i] = outcome if running else ended[i]
