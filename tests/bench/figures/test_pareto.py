"""Points that nobody beats, and the figure that joins them."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from hhrl_bench.evaluation.records import ResultRecord
from hhrl_bench.figures.pareto import draw_pareto, non_dominated, save_pareto
from hhrl_bench.figures.style import style
from support.boards import board, result


def test_points_beaten_in_both_or_in_one_with_the_other_equal_are_dominated() -> None:
    points = np.array([[1.0, 5.0], [2.0, 2.0], [2.0, 3.0], [5.0, 1.0], [6.0, 6.0], [5.0, 1.0]])
    assert non_dominated(points).tolist() == [True, True, False, True, False, True]
    assert non_dominated(np.zeros((0, 2))).tolist() == []


@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5)), min_size=1, max_size=8))
def test_every_point_is_on_the_front_or_beaten_by_one_that_is(points: list[tuple[int, int]]) -> None:
    front = non_dominated(np.array(points, np.float64))
    assert front.any()
    for (x, y), on in zip(points, front, strict=True):
        beaten = [a <= x and b <= y and (a, b) != (x, y) for (a, b), f in zip(points, front, strict=True) if f]
        assert any(beaten) != on


def placed(agent: str, steps: float, unsmooth: float, success: float) -> ResultRecord:
    return result(agent, steps=steps, unsmooth=unsmooth, success=success)


def drawn(*results: ResultRecord) -> Figure:
    with style():
        return draw_pareto(board(results))


def marks(figure: Figure) -> dict[str, Line2D]:
    return {str(line.get_label()): line for line in figure.axes[0].get_lines() if line.get_marker() not in {"", "None"}}


def test_successes_are_filled_failures_hollow_and_the_front_of_the_successes_joined() -> None:
    figure = drawn(
        placed("rule-3", 100.0, 5.0, 0.93),
        placed("ddqn", 150.0, 4.0, 0.99),
        placed("hybrid-hrl", 160.0, 4.5, 1.0),
        placed("rule-plus", 200.0, 1.0, 1.0),
        placed("rule-4", 150.0, 3.0, 0.92),
    )
    (axes,) = figure.axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("mean time of an episode [s]", "unsmooth steps an episode")
    hollow = {name for name, mark in marks(figure).items() if mark.get_markerfacecolor() == "white"}
    assert (hollow, len(marks(figure))) == ({"rule-4"}, 5)
    np.testing.assert_allclose(axes.get_lines()[0].get_xydata(), [[10.0, 5.0], [15.0, 4.0], [20.0, 1.0]])  # type: ignore[arg-type]
    [legend] = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["rule-3", "rule-4", "rule-plus", "ddqn", "hybrid-hrl"]


def test_an_oracle_is_drawn_and_is_no_end_of_the_line() -> None:
    seer = placed("oracle", 90.0, 0.5, 1.0).model_copy(update={"kind": "oracle"})
    figure = drawn(seer, placed("rule-3", 100.0, 5.0, 1.0), placed("rule-4", 150.0, 3.0, 1.0))
    assert {*marks(figure)} == {"oracle", "rule-3", "rule-4"}
    np.testing.assert_allclose(figure.axes[0].get_lines()[0].get_xydata(), [[10.0, 5.0], [15.0, 3.0]])  # type: ignore[arg-type]


def test_who_lies_far_beyond_the_successes_is_named() -> None:
    figure = drawn(placed("rule-3", 100.0, 5.0, 1.0), placed("ddqn", 150.0, 4.0, 1.0), placed("rule-2", 10.0, 5.0, 0.1))
    assert figure.axes[0].get_title(loc="left") == "stop-line-v0\nbeyond: rule-2"
    assert {*marks(figure)} == {"rule-3", "ddqn"}


def test_where_none_succeeds_all_are_shown() -> None:
    figure = drawn(placed("rule-3", 100.0, 5.0, 0.5), placed("rule-2", 10.0, 5.0, 0.1))
    assert figure.axes[0].get_title(loc="left") == "stop-line-v0"
    assert {*marks(figure)} == {"rule-2", "rule-3"}
    assert figure.axes[0].get_lines()[0].get_xydata().shape == (0, 2)  # type: ignore[union-attr]


@pytest.mark.parametrize(
    "results",
    [
        [result("rule-1")],
        [result("rule-1"), result("rule-2", option="stop")],
        [result("rule-1"), result("rule-2", "follow-v0")],
    ],
    ids=["one", "option-held", "another-task"],
)
def test_a_task_with_one_free_agent_has_no_figure(tmp_path: Path, results: list[ResultRecord]) -> None:
    assert save_pareto(board(results), tmp_path) == []
    assert not [*tmp_path.iterdir()]
