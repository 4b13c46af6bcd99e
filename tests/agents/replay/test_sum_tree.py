import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from hhrl_agents.replay.sum_tree import FAN_OUT, SumTrees
from hhrl_envs.arrays import Floats

SIZES = pytest.mark.parametrize("leaves", [8, 9, 64, 65, 1000])
ABOVE = np.nextafter(1.0, 0.0)


def tree_of(priorities: Floats) -> SumTrees:
    trees = SumTrees(1, priorities.size)
    trees.assign(np.arange(priorities.size)[None], priorities[None])
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
        trees.assign(np.array([indices]), np.array([priorities]))
        for index, priority in changes:
            kept[index] = priority
    assert_sums(trees, leaves)
    np.testing.assert_array_equal(trees.priorities(np.arange(leaves)[None])[0], kept)
    np.testing.assert_allclose(trees.totals, [kept.sum()], rtol=1e-12)


@settings(deadline=None)
@given(
    st.lists(st.floats(0, 100), min_size=1, max_size=80).filter(lambda p: sum(p) > 1e-300),
    st.floats(0, 1, exclude_max=True),
)
def test_a_share_finds_the_leaf_that_covers_it(priorities: list[float], share: float) -> None:
    found = int(tree_of(np.array(priorities)).find(np.array([[share]]))[0, 0])
    assert priorities[found] > 0
    ends = np.cumsum(priorities) / sum(priorities)
    starts = ends - np.array(priorities) / sum(priorities)
    assert starts[found] - 1e-9 <= share <= ends[found] + 1e-9


@SIZES
def test_leaves_are_drawn_with_their_exact_chances(leaves: int) -> None:
    priorities = some_priorities(leaves)
    shares = np.random.default_rng(5).random((1, 200_000))
    counts = np.bincount(tree_of(priorities).find(shares)[0], minlength=leaves)
    held = priorities > 0
    assert len(counts) == leaves
    assert not counts[~held].any()
    expected = priorities[held] / priorities.sum() * counts.sum()
    assert stats.chisquare(counts[held], expected).pvalue > 1e-3


@SIZES
def test_the_lowest_and_the_highest_share_find_the_first_and_the_last_priority(leaves: int) -> None:
    priorities = some_priorities(leaves)
    found = tree_of(priorities).find(np.array([[0.0, np.finfo(float).tiny, ABOVE, 1.0]]))[0]
    first, last = np.flatnonzero(priorities)[[0, -1]]
    assert list(found) == [first, first, last, last]


@SIZES
def test_the_ends_of_leaves_never_find_a_zero(leaves: int) -> None:
    priorities = some_priorities(leaves)
    ends = np.cumsum(priorities) / priorities.sum()
    shares = np.concatenate((ends, np.nextafter(ends, 0.0), np.nextafter(ends, 2.0))).clip(0.0, ABOVE)
    assert (priorities[tree_of(priorities).find(shares[None])[0]] > 0).all()


@SIZES
def test_a_single_priority_is_always_found(leaves: int) -> None:
    shares = np.array([[0.0, 0.3, 0.999, ABOVE]])
    for only in {0, leaves // 2, leaves - 1}:
        for priority in (1e-12, 1.0, 1e12):
            priorities = np.zeros(leaves)
            priorities[only] = priority
            assert (tree_of(priorities).find(shares) == only).all()


def test_of_an_index_twice_the_last_priority_counts() -> None:
    trees = SumTrees(1, 9)
    trees.assign(np.array([[8, 8]]), np.array([[3.0, 2.0]]))
    assert trees.totals.tolist() == [2.0]
    assert_sums(trees, 9)


def test_trees_do_not_touch_each_other() -> None:
    trees = SumTrees(3, 8)
    trees.assign(np.array([[1, 2], [3, 3], [0, 7]]), np.array([[1.0, 3.0], [5.0, 6.0], [0.0, 2.0]]))
    np.testing.assert_array_equal(trees.totals, [4.0, 6.0, 2.0])
    np.testing.assert_array_equal(trees.find(np.full((3, 2), 0.5)), [[2, 2], [3, 3], [7, 7]])


def test_one_row_serves_all_trees() -> None:
    trees = SumTrees(3, 70)
    trees.assign(np.array([[5, 69]]), np.array([[1.0], [2.0], [4.0]]))
    np.testing.assert_array_equal(trees.priorities(np.full((3, 1), 69)), [[1.0], [2.0], [4.0]])
    np.testing.assert_array_equal(trees.totals, [2.0, 4.0, 8.0])
