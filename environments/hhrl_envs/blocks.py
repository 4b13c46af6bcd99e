"""Finding the records of a block in the memory of a batch; see ``layout``."""

import numpy as np

from hhrl_envs import layout as at
from hhrl_envs.compiled import Floats, inner, unsigned


@inner
def block_of(row: int) -> int:
    """Return the number of the block that a row lies in."""
    return row // at.LANES


@inner
def locate(block: int, c: Floats) -> tuple[int, int, int]:
    """Return where the records of a block begin: the ego's vehicle, the ego as an agent, the rows."""
    vehicles, agents = unsigned(c[at.SLOTS]) * at.VEHICLE, unsigned(c[at.AGENTS]) * at.AGENT
    begin = block * (vehicles + agents + at.ROW)
    return begin, begin + vehicles, begin + vehicles + agents


def new_memory(rows: int, slots: int, agents: int) -> Floats:
    """Return the memory of a batch whose rows have no episode yet; front vehicles have profiles of ones."""
    blocks = -(-rows // at.LANES)
    vehicles = np.zeros((blocks, slots, at.VEHICLE))
    vehicles[:, :, at.PROFILE :] = 1.0
    rest = np.zeros((blocks, agents * at.AGENT + at.ROW))
    return np.concatenate([vehicles.reshape(blocks, -1), rest], axis=1).ravel()
