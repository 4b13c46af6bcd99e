import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from hhrl_agents.replay import sum_tree
from hhrl_agents.replay.sum_tree import FAN_OUT, SumTrees
from hhrl_envs.arrays import Floats, Ints
from hhrl_envs.simulation.engine.compilation import kernel

_assign, _find = sum_tree.assign, sum_tree.find

SIZES = pytest.mark.parametrize("leaves", [8, 9, 64, 65, 1000])
ABOVE = np.nextafter(1.0, 0.0)


@kernel
def assign_in(nodes: Floats, starts: Ints, indices: Ints, priorities: Floats) -> None:
    _assign(nodes, starts, indices, priorities)


@kernel
def find_in(nodes: Floats, starts: Ints, shares: Floats, found: Ints) -> None:
    _find(nodes, starts, shares, found)


def assign(trees: SumTrees, indices: list[int], priorities: list[list[float]]) -> None:
    """Set the priorities [T, K] of the leaves [K]."""
    assign_in(trees.nodes, trees.starts, np.array(indices), np.array(priorities))


def find_in_each(trees: SumTrees, shares: Floats) -> Ints:
    """The leaves of every tree at these shares, both [T, K]."""
    found = np.empty(shares.shape, np.int64)
    find_in(trees.nodes, trees.starts, shares.copy(), found)
    return found


def find(trees: SumTrees, shares: Floats) -> Ints:
    """The leaves of a single tree at these shares, [K]."""
    found: Ints = find_in_each(trees, shares[None])[0]
    return found


def priorities_of(trees: SumTrees, leaves: int) -> Floats:
    first = trees.starts[-1]
    return trees.nodes[:, first : first + leaves]


def totals(trees: SumTrees) -> Floats:
    sums: Floats = trees.nodes[:, :FAN_OUT].sum(axis=1)
    return sums


def tree_of(priorities: Floats) -> SumTrees:
    trees = SumTrees(1, priorities.size)
    assign(trees, list(range(priorities.size)), [priorities.tolist()])
    return trees


def some_priorities(leaves: int) -> Floats:
    """Priorities of very different size, a fifth of them zero, the first and the last one too."""
    rng = np.random.default_rng(leaves)
    priorities: Floats = rng.random(leaves) * rng.choice([0.0, 0.2, 1.0, 1.0, 5.0], leaves)
    priorities[[0, -1]] = 0.0
    return priorities


def assert_sums(trees: SumTrees, leaves: int) -> None:
    """Every inner node of every tree is the sum of its children, from the leaves to the root's children."""
    below = -(-leaves // FAN_OUT) * FAN_OUT
    end = trees.nodes.shape[1]
    while below > FAN_OUT:
        children = trees.nodes[:, end - below : end].reshape(len(trees.nodes), -1, FAN_OUT)
        end, nodes = end - below, children.shape[1]
        below = -(-nodes // FAN_OUT) * FAN_OUT
        parents = trees.nodes[:, end - below : end]
        np.testing.assert_allclose(parents[:, :nodes], children.sum(-1), rtol=1e-14)
        assert not parents[:, nodes:].any()
    assert end == below


@settings(deadline=None)
@given(st.data(), st.sampled_from([1, 8, 9, 13, 64, 65, 600]))
def test_every_node_is_the_sum_of_its_children(data: st.DataObject, leaves: int) -> None:
    change = st.tuples(st.integers(0, leaves - 1), st.floats(0, 1e6))
    calls = data.draw(st.lists(st.lists(change, min_size=1, max_size=20), min_size=1, max_size=6))
    trees, kept = SumTrees(1, leaves), np.zeros(leaves)
    for changes in calls:
        indices, priorities = zip(*changes, strict=True)
        assign(trees, list(indices), [list(priorities)])
        for index, priority in changes:
            kept[index] = priority
    assert_sums(trees, leaves)
    np.testing.assert_array_equal(priorities_of(trees, leaves)[0], kept)
    np.testing.assert_allclose(totals(trees), [kept.sum()], rtol=1e-12)


@settings(deadline=None)
@given(
    st.lists(st.floats(0, 100), min_size=1, max_size=80).filter(lambda p: sum(p) > 1e-300),
    st.floats(0, 1, exclude_max=True),
)
def test_a_share_finds_the_leaf_that_covers_it(priorities: list[float], share: float) -> None:
    found = int(find(tree_of(np.array(priorities)), np.array([share]))[0])
    assert priorities[found] > 0
    ends = np.cumsum(priorities) / sum(priorities)
    starts = ends - np.array(priorities) / sum(priorities)
    assert starts[found] - 1e-9 <= share <= ends[found] + 1e-9


@SIZES
def test_leaves_are_drawn_with_their_exact_chances(leaves: int) -> None:
    priorities = some_priorities(leaves)
    shares = np.random.default_rng(5).random(200_000)
    counts = np.bincount(find(tree_of(priorities), shares), minlength=leaves)
    held = priorities > 0
    assert len(counts) == leaves
    assert not counts[~held].any()
    expected = priorities[held] / priorities.sum() * counts.sum()
    assert stats.chisquare(counts[held], expected).pvalue > 1e-3


@SIZES
def test_the_lowest_and_the_highest_share_find_the_first_and_the_last_priority(leaves: int) -> None:
    priorities = some_priorities(leaves)
    found = find(tree_of(priorities), np.array([0.0, np.finfo(float).tiny, ABOVE, 1.0]))
    first, last = np.flatnonzero(priorities)[[0, -1]]
    assert list(found) == [first, first, last, last]


@SIZES
def test_the_ends_of_leaves_never_find_a_zero(leaves: int) -> None:
    priorities = some_priorities(leaves)
    ends = np.cumsum(priorities) / priorities.sum()
    shares = np.concatenate((ends, np.nextafter(ends, 0.0), np.nextafter(ends, 2.0))).clip(0.0, ABOVE)
    assert (priorities[find(tree_of(priorities), shares)] > 0).all()


@SIZES
def test_a_single_priority_is_always_found(leaves: int) -> None:
    shares = np.array([0.0, 0.3, 0.999, ABOVE])
    for only in {0, leaves // 2, leaves - 1}:
        for priority in (1e-12, 1.0, 1e12):
            priorities = np.zeros(leaves)
            priorities[only] = priority
            assert (find(tree_of(priorities), shares) == only).all()


def test_of_an_index_twice_the_last_priority_counts() -> None:
    trees = SumTrees(1, 9)
    assign(trees, [8, 8], [[3.0, 2.0]])
    assert totals(trees).tolist() == [2.0]
    assert_sums(trees, 9)


@SIZES
def test_no_index_changes_nothing(leaves: int) -> None:
    trees = tree_of(some_priorities(leaves))
    before = trees.nodes.copy()
    assign(trees, [-1, -1], [[7.0, 9.0]])
    np.testing.assert_array_equal(trees.nodes, before)


def test_trees_do_not_touch_each_other() -> None:
    trees = SumTrees(3, 70)
    assign(trees, [5, 69], [[1.0, 3.0], [6.0, 2.0], [0.0, 2.0]])
    np.testing.assert_array_equal(totals(trees), [4.0, 8.0, 2.0])
    np.testing.assert_array_equal(priorities_of(trees, 70)[:, [5, 69]], [[1.0, 3.0], [6.0, 2.0], [0.0, 2.0]])
    found = find_in_each(trees, np.full((3, 2), 0.5))
    np.testing.assert_array_equal(found, [[69, 69], [5, 5], [69, 69]])
