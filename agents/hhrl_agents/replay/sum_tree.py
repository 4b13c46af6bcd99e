"""Sum trees: draw one of many leaves in proportion to its priority, in logarithmic time.

Every node has eight children side by side, one cache line, and is their sum, computed anew at each change, so that
errors do not add up. A tree is one row of numbers, its levels one after the other, the root's children first.
"""

import numpy as np
import numpy.typing as npt

from hhrl_envs.arrays import Floats, Ints
from hhrl_envs.simulation.engine.compilation import kernel

FAN_OUT = 8


class SumTrees:
    """T trees of the same number of `leaves`, all priorities zero at first."""

    def __init__(self, count: int, leaves: int) -> None:
        sizes = [_padded(leaves)]
        while sizes[0] > FAN_OUT:
            sizes.insert(0, _padded(sizes[0] // FAN_OUT))
        self._starts = np.cumsum([0, *sizes[:-1]])
        self.nodes: Floats = np.zeros((count, sum(sizes)))

    @property
    def totals(self) -> Floats:
        """The sum of each tree's priorities, float64 [T]."""
        totals: Floats = self.nodes[:, :FAN_OUT].sum(axis=1)
        return totals

    def priorities(self, indices: Ints) -> Floats:
        """Return the priorities of the leaves `indices` [T, K]."""
        return np.take_along_axis(self.nodes, self._starts[-1] + indices, axis=1)

    def assign(self, indices: Ints, priorities: Floats) -> None:
        """Set the priorities [T, K] of the leaves `indices` [T, K]; of an index twice the last counts.

        An index of -1 is no leaf.

        Both may have a first axis of length 1, for all trees alike.
        """
        shape = (len(self.nodes), indices.shape[1])
        _assign(self.nodes, self._starts, np.broadcast_to(indices, shape), np.broadcast_to(priorities, shape))

    def find(self, shares: Floats) -> Ints:
        """Return the leaf at each share, int64 [T, K]: leaf i covers the shares that its priority is of all before it.

        shares: [T, K] in [0, 1) of each tree's total, which must be positive. A leaf of priority zero is not returned.
        """
        return _find(self.nodes, self._starts, shares)


def _padded(size: int) -> int:
    return -(-size // FAN_OUT) * FAN_OUT


@kernel
def _assign(nodes: Floats, starts: npt.NDArray[np.int64], indices: Ints, priorities: Floats) -> None:
    for t in range(indices.shape[0]):
        for k in range(indices.shape[1]):
            if indices[t, k] >= 0:
                nodes[t, starts[-1] + indices[t, k]] = priorities[t, k]
        width = FAN_OUT
        for level in range(len(starts) - 1, 0, -1):
            for k in range(indices.shape[1]):
                parent = max(indices[t, k], 0) // width  # of -1 any node, whose sum does not change
                first = starts[level] + parent * FAN_OUT
                total = 0.0
                for child in range(FAN_OUT):
                    total += nodes[t, first + child]
                nodes[t, starts[level - 1] + parent] = total
            width *= FAN_OUT


@kernel
def _find(nodes: Floats, starts: npt.NDArray[np.int64], shares: Floats) -> Ints:
    found = np.zeros(shares.shape, np.int64)
    rest = np.empty(shares.shape[1])
    for t in range(shares.shape[0]):
        total = 0.0
        for child in range(FAN_OUT):
            total += nodes[t, child]
        for k in range(shares.shape[1]):
            rest[k] = shares[t, k] * total
        for start in starts:  # level by level, so that the searches wait for memory together
            for k in range(shares.shape[1]):
                first, taken = start + found[t, k] * FAN_OUT, 0
                beyond = kept = rest[k]
                for child in range(FAN_OUT):
                    priority = nodes[t, first + child]
                    within = (priority > 0.0) & (beyond >= 0.0)
                    kept, taken = (beyond, child) if within else (kept, taken)
                    beyond -= priority
                rest[k] = kept if beyond < 0.0 else total  # beyond all by a rounding: the last one with a priority
                found[t, k] = found[t, k] * FAN_OUT + taken
    return found
