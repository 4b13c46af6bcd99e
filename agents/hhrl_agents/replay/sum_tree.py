"""Sum trees: draw one of many leaves in proportion to its priority, in logarithmic time.

Every node has eight children side by side, one cache line, and is their sum, computed anew at each change, so that
errors do not add up. A tree is one row of numbers, its levels one after the other, the root's children first.
"""

import numpy as np

from hhrl_envs.arrays import Floats, Ints
from hhrl_envs.simulation.engine.compilation import inner, kernel, spliced

FAN_OUT = 8


class SumTrees:
    """T trees of the same number of `leaves`, all priorities zero at first.

    nodes: float64 [T, numbers]; starts: int64 [levels], where each level's nodes begin, the leaves' last.
    """

    def __init__(self, count: int, leaves: int) -> None:
        sizes = [_padded(leaves)]
        while sizes[0] > FAN_OUT:
            sizes.insert(0, _padded(sizes[0] // FAN_OUT))
        self.starts: Ints = np.cumsum([0, *sizes[:-1]])
        self.nodes: Floats = np.zeros((count, sum(sizes)))


def _padded(size: int) -> int:
    return -(-size // FAN_OUT) * FAN_OUT


@inner
def assign(nodes: Floats, starts: Ints, indices: Ints, priorities: Floats) -> None:
    """Set the priorities [T, K] of the leaves `indices` [K]; of an index twice the last counts, and -1 is none."""
    for t in range(nodes.shape[0]):
        for k in range(indices.size):
            if indices[k] >= 0:
                nodes[t, starts[-1] + indices[k]] = priorities[t, k]
        width = FAN_OUT
        for level in range(len(starts) - 1, 0, -1):
            for k in range(indices.size):
                parent = max(indices[k], 0) // width  # of -1 any node, whose sum does not change
                first = starts[level] + parent * FAN_OUT
                total = 0.0
                for child in range(FAN_OUT):
                    total += nodes[t, first + child]
                nodes[t, starts[level - 1] + parent] = total
            width *= FAN_OUT


@kernel
def place(nodes: Floats, starts: Ints, indices: Ints, priorities: Floats) -> None:
    """Do as `assign` does, called from Python."""
    assign(nodes, starts, indices, priorities)


@spliced
def find(nodes: Floats, starts: Ints, shares: Floats, found: Ints) -> None:
    """Write the leaf at each share, int64 [T, K]: leaf i covers the shares that its priority is of all before it.

    shares: [T, K] in [0, 1) of each tree's total, which must be positive; what they become has no meaning. A leaf of
    priority zero is not found.
    """
    for t in range(shares.shape[0]):
        total = 0.0
        for child in range(FAN_OUT):
            total += nodes[t, child]
        for k in range(shares.shape[1]):
            shares[t, k] *= total
            found[t, k] = 0
        for start in starts:  # level by level, so that the searches wait for memory together
            for k in range(shares.shape[1]):
                first, taken = start + found[t, k] * FAN_OUT, 0
                beyond = kept = shares[t, k]
                for child in range(FAN_OUT):
                    priority = nodes[t, first + child]
                    within = (priority > 0.0) & (beyond >= 0.0)
                    kept, taken = (beyond, child) if within else (kept, taken)
                    beyond -= priority
                shares[t, k] = kept if beyond < 0.0 else total  # beyond all by a rounding: the last one with a priority
                found[t, k] = found[t, k] * FAN_OUT + taken
