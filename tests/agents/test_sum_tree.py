import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from hhrl_agents.sum_tree import assign, empty_trees, find


def test_a_tree_has_room_for_its_leaves() -> None:
    for leaves, size in ((1, 2), (2, 4), (3, 8), (4, 8), (100, 256)):
        assert empty_trees(3, leaves).shape == (3, size)


@settings(deadline=None)
@given(st.lists(st.tuples(st.integers(0, 12), st.floats(0, 1e6)), min_size=1, max_size=60))
def test_every_node_is_the_sum_of_its_children(changes: list[tuple[int, float]]) -> None:
    trees = empty_trees(1, 13)
    for index, priority in changes:
        assign(trees, np.array([[index]]), np.array([[priority]]))
    leaves = trees.shape[1] // 2
    for node in range(1, leaves):
        assert trees[0, node] == trees[0, 2 * node] + trees[0, 2 * node + 1]
    for index, priority in dict(changes).items():
        assert trees[0, leaves + index] == priority


@settings(deadline=None)
@given(
    st.lists(st.floats(0, 100), min_size=2, max_size=20).filter(lambda p: sum(p) > 0), st.floats(0, 1, exclude_max=True)
)
def test_a_share_finds_the_leaf_that_covers_it(priorities: list[float], share: float) -> None:
    trees = empty_trees(1, len(priorities))
    assign(trees, np.arange(len(priorities))[None], np.array([priorities]))
    found = int(find(trees, np.array([[share]]))[0, 0])
    assert priorities[found] > 0
    ends = np.cumsum(priorities) / sum(priorities)
    starts = ends - np.array(priorities) / sum(priorities)
    assert starts[found] - 1e-9 <= share <= ends[found] + 1e-9


def test_leaves_are_drawn_with_their_exact_chances() -> None:
    rng = np.random.default_rng(5)
    priorities = np.concatenate((rng.random(40), [0.0, 0.0, 30.0], rng.random(27) * 0.1))
    trees = empty_trees(1, priorities.size)
    assign(trees, np.arange(priorities.size)[None], priorities[None])
    counts = np.bincount(find(trees, rng.random((1, 200_000)))[0], minlength=priorities.size)
    assert counts[priorities == 0].sum() == 0
    held = priorities > 0
    expected = priorities[held] / priorities.sum() * counts.sum()
    assert stats.chisquare(counts[held], expected).pvalue > 1e-3


def test_trees_do_not_touch_each_other() -> None:
    trees = empty_trees(3, 8)
    assign(trees, np.array([[1, 2], [3, 3], [0, 7]]), np.array([[1.0, 3.0], [5.0, 6.0], [0.0, 2.0]]))
    np.testing.assert_array_equal(trees[:, 1], [4.0, 6.0, 2.0])
    np.testing.assert_array_equal(find(trees, np.full((3, 2), 0.5)), [[2, 2], [3, 3], [7, 7]])
