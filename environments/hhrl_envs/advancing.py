"""The kernel of the simulator: it moves the rows of a batch, begins their episodes and shows what their agents get."""

from hhrl_envs import layout as at
from hhrl_envs.beginning import begin
from hhrl_envs.blocks import locate
from hhrl_envs.compiled import Codes, Floats, Floats32, Keys, kernel, unsigned
from hhrl_envs.stepping import appraise, hand_out, move

MOVE, BEGIN, SHOW = 1, 2, 4  # what there is to do, to be added up
MOVE_AND_SHOW = MOVE | SHOW
BACKWARDS = 8  # to be added where the blocks are to be taken from the last to the first


@kernel
def advance_rows(
    m: Floats, c: Floats, keys: Keys, observations: Floats32, results: Floats, codes: Codes,
    parts: int, special: bool | None, low: int, high: int,
) -> int:  # fmt: skip
    """Do the ``parts`` of a step for the blocks from low to high and return how many agents have ended.

    It is -1 if rows cannot begin yet, because their worlds are OPEN; see ``beginning``.

    MOVE is one step of all rows, BEGIN the beginning of the episodes that are due, SHOW fills ``observations``, float32
    [11, agent, row], ``results``, float64 [RESULTS_SIZE, agent, row], and ``codes``, int8 [3, agent, row]: the outcome,
    whether it terminated the episode, whether it truncated it. To SHOW a step again changes nothing.

    ``keys``, uint64 [2, row], are seed and episode of the rows. ``special`` is None for an ego alone that has to stop
    at one line, so that what other scenarios need is not even compiled. Agents that had ended before keep their outcome
    and earn nothing. BACKWARDS in every other step begins with the blocks that the step before has left in the cache.
    """
    ended, still_open, rows = 0, 0, unsigned(observations.shape[2])
    for n in range(unsigned(high - low)):
        block = unsigned(high) - unsigned(1) - n if parts & BACKWARDS else unsigned(low) + n
        s, r = locate(block, c)
        first = block * unsigned(at.LANES)
        lanes = min(unsigned(at.LANES), rows - first)
        if parts & MOVE:
            move(m, s, r, c, special, lanes)
        if parts & BEGIN:
            still_open += begin(m, s, r, keys, first, c, special, lanes)
        if parts & SHOW:
            appraise(m, s, r, c, special, lanes)
            ended += hand_out(m, s, observations, results, codes, first, lanes)
    return -1 if still_open > 0 else ended
