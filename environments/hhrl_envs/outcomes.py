"""How an episode ends: exclusive and exhaustive outcomes."""

from enum import IntEnum

from hhrl_envs import layout
from hhrl_envs.compiled import Codes, Floats, Ints, kernel
from hhrl_envs.goals import FOLLOW, PASS, STOP


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


RUNNING, COLLISION, NOT_STOP, SUCCESS, TIMEOUT, REAR_ENDED = (int(outcome) for outcome in Outcome)


@kernel
def judge(
    state: Floats,
    rows: Floats,
    steps: Ints,
    before: Codes,
    ended: Codes,
    fresh: Codes,
    k: int,
    c: Floats,
    low: int,
    high: int,
) -> None:
    """Write the outcome of agent ``k`` into ``ended``; one that had ended ``before`` keeps its outcome.

    ``fresh`` is the outcome of those that end in this very step, so that an ending is rewarded once. All are int8
    [agent, row].
    """
    length, zone, slow, horizon = c[layout.LENGTH], c[layout.STOP_ZONE], c[layout.STOP_SPEED], c[layout.HORIZON]
    stops, passes, follows = c[layout.GOAL] == STOP, c[layout.GOAL] == PASS, c[layout.GOAL] == FOLLOW
    last, end, needed = c[layout.LAST_LINE], c[layout.ROUTE_END], c[layout.BAND_SHARE] * horizon
    for i in range(low, high):
        x, line = state[layout.POSITION, k, i], state[layout.LINE, k, i]
        d_f = state[layout.POSITION, k + 1, i] - length - x
        late = steps[i] >= horizon
        stopped = stops & (line == last) & (line - x <= zone) & (state[layout.SPEED, k, i] < slow)
        followed = follows & late & (rows[layout.KEPT, i] >= needed)
        outcome = TIMEOUT if late else RUNNING
        outcome = SUCCESS if stopped | followed | (passes & (x > end)) else outcome
        outcome = NOT_STOP if x > line else outcome
        outcome = COLLISION if d_f <= 0.0 else outcome
        running = before[k, i] == RUNNING
        fresh[k, i] = outcome if running else RUNNING
        ended[k, i] = outcome if running else before[k, i]
