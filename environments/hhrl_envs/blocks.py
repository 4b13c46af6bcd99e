"""Finding the records of a block in the memory of a batch; see ``layout``."""

from hhrl_envs import layout as at
from hhrl_envs.compiled import Floats, inner, unsigned


@inner
def locate(block: int, c: Floats) -> tuple[int, int]:
    """Return where the records of a block begin: the ego's, the rows'."""
    begin = block * (at.ROW + unsigned(c[at.SLOTS]) * at.VEHICLE)
    return begin + at.ROW, begin


@inner
def locate_row(row: int, c: Floats) -> tuple[int, int]:
    """Return the places of one row: the records of its block, see ``locate``, plus its lane."""
    s, r = locate(unsigned(row // at.LANES), c)
    lane = unsigned(row % at.LANES)
    return s + lane, r + lane
