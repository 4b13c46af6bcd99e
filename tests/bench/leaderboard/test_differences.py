"""Differences name every place at which two records differ, and no other."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hhrl_bench.leaderboard.findings import Finding, differences

JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=3), inner, max_size=4),
    max_leaves=12,
)


@given(JSON)
def test_nothing_differs_from_itself(data: Any) -> None:
    assert list(differences("here", data, data)) == []


@pytest.mark.parametrize(
    ("published", "found", "said"),
    [
        ({"a": {"b": [1, 2.5]}}, {"a": {"b": [1, 2.25]}}, "a.b[1]: 2.5 is published, 2.25 was found"),
        ({"a": 1}, {}, "a: 1 is published, nothing was found"),
        ({}, {"a": 1}, "a: nothing is published, 1 was found"),
        ({"a": [1, 2]}, {"a": [1]}, "a: [1, 2] is published, [1] was found"),
        ({"a": True}, {"a": 1}, "a: True is published, 1 was found"),
        ({"a": 1}, {"a": 1.0}, "a: 1 is published, 1.0 was found"),
        ({"a": "x"}, {"a": "y"}, "a: x is published, y was found"),
        ({"a": "x\ny"}, {"a": None}, "a: x y is published, nothing was found"),
        ({"a": "\x1b[2J"}, {"a": None}, "a: \\x1b[2J is published, nothing was found"),
    ],
)
def test_a_difference_is_one_line_with_its_place(published: Any, found: Any, said: str) -> None:
    assert [str(finding) for finding in differences("", published, found)] == [said]


def test_long_words_are_cut() -> None:
    (finding,) = differences("a", "x" * 500, "")
    assert finding == Finding("a", f"{'x' * 77}... is published,  was found")
