"""Sigma is recovered from tables whose sigma is known, and from the paper's own with the figures that are published."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hhrl_bench.calibration.reward_constants import HELD, SIGMAS, SigmaRecord, measure, ranges, recover
from hhrl_bench.paper_table import TABLE_I, PaperRow
from support.command_line import invoke

PAPER = {reading.name: reading for reading in measure().readings}
constants = st.floats(0.0, 100.0)
shares = st.floats(0.0, 1.0)


def row(sigma: tuple[float, ...], speed: float, split: float, like: PaperRow, *, unsafe: bool = True) -> PaperRow:
    """Return a row of Table I with rewards that follow from sigma; ``split`` of what may be either level's is r^o's."""
    collision_o = {"rule-1": 0.0, "rule-2": 1.0}.get(like.counterpart, split)
    line_o = {"rule-1": 1.0, "rule-2": 0.0}.get(like.counterpart, split)
    unsafe_sum = like.unsafe if unsafe else 0.0
    common = sigma[3] * like.success / 100 - sigma[0] * like.steps
    collision, line = sigma[2] * like.collision / 100, speed**2 * like.not_stop / 100
    option = common - split * unsafe_sum - collision_o * collision - line_o * line
    charged = (1 - split) * unsafe_sum + (1 - collision_o) * collision + (1 - line_o) * line
    return like._replace(
        unsafe=unsafe_sum, return_option=option, return_action=common - sigma[1] * like.unsmooth - charged
    )


@given(st.tuples(*[constants] * 4), st.floats(0.0, 15.0))
def test_sigma_and_the_speed_come_out_of_a_table_that_fixes_them(sigma: tuple[float, ...], speed: float) -> None:
    found = recover([row(sigma, speed, 0.0, like, unsafe=False) for like in TABLE_I[:2] + TABLE_I[4:]])
    assert found.sigma == pytest.approx(sigma, abs=1e-5)
    assert found.line_speed[0] ** 2 == pytest.approx(speed**2, abs=1e-5)
    assert found.largest < 1e-6


@given(st.tuples(*[constants] * 4), st.lists(shares, min_size=5, max_size=5))
def test_where_the_splits_are_open_sigma_lies_in_its_range(sigma: tuple[float, ...], splits: list[float]) -> None:
    rows = [row(sigma, 6.0, split, like) for split, like in zip(splits, TABLE_I, strict=True)]
    assert recover(rows).largest < 1e-6
    for value, (low, high) in zip(sigma, ranges(rows, 1e-6), strict=True):
        assert low - 1e-3 <= value <= high + 1e-3


def test_what_is_held_stays_and_leaves_no_less() -> None:
    for name, held in HELD.items():
        assert {key: PAPER[name].sigma[key] for key in held} == pytest.approx(held)
        assert PAPER[name].largest >= PAPER["recovered"].largest


def test_no_sigma_leaves_less_than_the_recovered_one() -> None:
    largest = PAPER["recovered"].largest
    for value, (low, high) in zip(PAPER["recovered"].sigma.values(), ranges(TABLE_I, largest + 1e-9), strict=True):
        assert (low, high) == pytest.approx((value, value), abs=1e-4)


def test_the_published_figures() -> None:
    assert list(PAPER["recovered"].sigma.values()) == pytest.approx([0.0, 2.560, 34.538, 46.955], abs=5e-4)
    largest = {name: reading.largest for name, reading in PAPER.items()}
    expected = {"recovered": 0.361, "default": 0.585, "sigma_1 = 0.1": 5.702, "sigma_4 = 100": 17.235, "both": 25.601}
    assert largest == pytest.approx(expected, abs=5e-4)
    residuals = [(policy.return_option, policy.return_action) for policy in PAPER["default"].policies]
    assert np.abs(residuals).max() == pytest.approx(PAPER["default"].largest)
    assert PAPER["recovered"].policies[0].line_speed == pytest.approx(6.1, abs=0.1)


def test_the_replication_report_says_what_comes_out() -> None:
    page = (Path(__file__).parents[3] / "REPLICATION.md").read_text()
    said = {"recovered": "recovered", "default": "used here", "both": "both"}
    said |= {name: f"{name}, the others free" for name in PAPER if name not in said}
    for name, reading in PAPER.items():
        cells = [f"{value:.3g}" for value in reading.sigma.values()]
        assert f"| {' | '.join([said[name], *cells, f'{reading.largest:.2f}'])} |" in page


def test_the_command_prints_a_table_and_the_record_as_json() -> None:
    table = invoke("sigma").stdout
    assert all(name in table for name in [*HELD, *SIGMAS, "Rule 1 r^o", "Hybrid HRL r^a"])
    assert "0.36" in table
    record = SigmaRecord.model_validate_json(invoke("sigma", "--json").stdout)
    assert [reading.name for reading in record.readings] == list(HELD)
    assert record.least["sigma_4"] < record.most["sigma_4"]
