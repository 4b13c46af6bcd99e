"""Names fit into a width, whole but for line ends, and break behind punctuation where they can."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hhrl_bench.text import LONGEST_FILE_NAME, file_name, folded, indented


@given(st.text(st.characters(codec="ascii", exclude_categories=["Cc", "Zs"]), max_size=80), st.integers(1, 30))
def test_a_name_is_whole_and_fits(name: str, width: int) -> None:
    lines = folded(name, width).split("\n")
    assert max(map(len, lines)) <= width
    assert "".join(lines) == name


@pytest.mark.parametrize(
    ("name", "lines"),
    [
        ("hybrid-hrl-plus", ["hybrid-hrl-", "plus"]),
        ("hybrid-hrl zero-shot", ["hybrid-hrl", "zero-shot"]),
        ("rule-4", ["rule-4"]),
        ("my_agent:make_agent", ["my_agent:", "make_agent"]),
        ("abcdefghijklmnop", ["abcdefghijkl", "mnop"]),
    ],
)
def test_a_name_breaks_behind_punctuation(name: str, lines: list[str]) -> None:
    assert folded(name, 12).split("\n") == lines


def test_an_indented_name_is_indented_on_every_line() -> None:
    assert indented("a" * 30) == f"  {'a' * 24}\n  {'a' * 6}"


@given(st.text(max_size=600))
def test_a_file_name_is_a_file_in_its_own_folder(name: str) -> None:
    made = file_name(name)
    assert re.fullmatch(r"[A-Za-z0-9_-]+", made + "x")
    assert len(made) <= LONGEST_FILE_NAME


def test_file_names_differ_where_names_do_and_plain_ones_stay() -> None:
    assert file_name("hybrid-hrl-plus") == "hybrid-hrl-plus"
    assert len({file_name(name) for name in ("a/b", "a_b", "a:b", "../a_b", "x" * 200, "x" * 201)}) == 6
