"""Sum trees: draw one of many leaves in proportion to its priority, in logarithmic time.

T trees of L leaves (a power of two) are one array, float64 [T, 2 L]: node 1 is the root, the children of node n are 2n
and 2n + 1, leaf i is node L + i. Every inner node is the sum of its children, computed anew at each change, so errors
do not add up.
"""

import numpy as np

from hhrl_agents.base import FloatArray, IntArray
from hhrl_envs.compiled import kernel


def empty_trees(count: int, leaves: int) -> FloatArray:
    """Return `count` trees with all priorities zero and room for at least `leaves` leaves each."""
    return np.zeros((count, 2 << (leaves - 1).bit_length()))


@kernel
def assign(trees: FloatArray, indices: IntArray, priorities: FloatArray) -> None:
    """Return nothing; set the priorities [T, K] of the leaves `indices` [T, K]; of an index twice the last counts."""
    leaves = trees.shape[1] // 2
    for t in range(indices.shape[0]):
        for k in range(indices.shape[1]):
            node = leaves + indices[t, k]
            trees[t, node] = priorities[t, k]
            while node > 1:
                node //= 2
                trees[t, node] = trees[t, 2 * node] + trees[t, 2 * node + 1]


@kernel
def find(trees: FloatArray, shares: FloatArray) -> IntArray:
    """Return the leaf at each share, int64 [T, K]: leaf i covers the shares that its priority is of all before it.

    shares: [T, K] in [0, 1) of each tree's total, which must be positive. A leaf of priority zero is never returned.
    """
    leaves = trees.shape[1] // 2
    found = np.empty(shares.shape, np.int64)
    for t in range(shares.shape[0]):
        for k in range(shares.shape[1]):
            rest, node = shares[t, k] * trees[t, 1], 1
            while node < leaves:
                left, right = trees[t, 2 * node], trees[t, 2 * node + 1]
                if rest < left or right == 0.0:
                    node = 2 * node
                else:
                    rest, node = rest - left, 2 * node + 1
            found[t, k] = node - leaves
    return found
