"""The table of comparisons fits its console, and says differences in the unit of the column."""

from io import StringIO

import numpy as np
import pytest
from rich.console import Console

from hhrl_bench.evaluation.metrics import columns
from hhrl_bench.leaderboard.comparisons import PairwiseRecord, Runs, compare
from hhrl_bench.tables.comparisons import comparison_tables
from hhrl_bench.tables.table import by_importance
from hhrl_bench.tables.terminal import print_tables
from hhrl_bench.text import NONE

METRICS = [metric.key for metric in by_importance(columns("results"))]


def study() -> list[PairwiseRecord]:
    """Return two agents beside rule-4 on two tasks, by every metric."""
    rule = Runs("rule-4", [np.array([0.5, 0.5])])
    learned = Runs("hybrid-hrl", [np.array([0.5, 1.0]), np.array([0.5, 0.5])])
    flat, other = Runs("ddqn", [np.array([np.nan, np.nan])] * 2), Runs("rule-plus", [np.array([0.0, 0.5])])
    return [
        compare(flat if agent is learned and metric.startswith("return") else agent, rule, task, metric, rng)
        for rng in [np.random.default_rng(0)]
        for task in ("stop-line-v0", "stop-line-wet-v0")
        for metric in METRICS
        for agent in (learned, other)
    ]


def printed(width: int) -> list[str]:
    out = StringIO()
    print_tables(Console(file=out, width=width), comparison_tables(study()))
    return out.getvalue().splitlines()


@pytest.mark.parametrize("width", [30, 50, 80, 120, 250])
def test_the_table_fits_and_names_every_agent_and_task(width: int) -> None:
    lines = printed(width)
    assert max(map(len, lines)) <= width
    text = " ".join(" ".join(lines).split())
    assert "…" not in text
    for task in ("stop-line-v0", "stop-line-wet-v0"):
        assert f"minus rule-4 on {task}, 2 test episodes" in text
    assert text.count("rule-plus") == text.count("hybrid-hrl") == 2
    assert ("wider terminal" in text) == (width < 250)


def test_differences_are_signed_and_of_rates_in_percentage_points() -> None:
    [learned, below, rule, *_] = [line.split() for line in printed(250)[4:]]
    assert learned[:3] == ["hybrid-hrl", "+0.125", "0.75"]
    assert learned[3:11] == ["+12.5", "0.75", "+12.5", "0.75", "+12.5", "0.75", "+12.5", "0.75"]
    assert learned[11:13] == ["+0.1", "0.75"]
    assert below[:8] == ["+0.000,", "+0.250", "0.50,", "1.00", "+0.0,", "+25.0", "0.50,", "1.00"]
    assert rule[:5] == ["rule-plus", "-0.250", NONE, "-25.0", NONE]


def test_a_metric_that_an_agent_has_not_is_a_dash() -> None:
    flat = next(line.split() for line in printed(250) if line.startswith("ddqn"))
    assert flat == ["ddqn", *[NONE] * 20]


def test_a_narrow_console_keeps_the_intervals_as_long_as_it_can() -> None:
    assert any("+0.0, +25.0" in line for line in printed(80))
    assert not any("+0.0, +25.0" in line for line in printed(30))


def test_every_metric_that_agents_are_compared_by_is_shown_the_score_first() -> None:
    table, _ = comparison_tables(study())
    headings = [column.wide for column in table.columns[::2]]
    assert len(headings) == len(METRICS)
    assert headings[:5] == ["score", "success", "collision", "not\nstop", "timeout"]


def test_one_agent_is_named_with_what_its_interval_is_of_and_no_probability_that_it_has_not() -> None:
    one, other = Runs("rule-4", [np.array([0.5, 0.5])]), Runs("rule-plus", [np.array([0.0, 0.5])])
    pairs = [compare(one, other, "stop-line-v0", metric, np.random.default_rng(0)) for metric in METRICS]
    (table,) = comparison_tables(pairs)
    assert table.full_title == "rule-4 minus rule-plus on stop-line-v0, 2 test episodes"
    assert [column.line for column in table.columns[:3]] == ["score", "success", "collision"]
    said = " ".join(note.text for note in table.notes)
    assert said.endswith("is its 95% interval, a bootstrap over the test episodes, world by world.")
    assert "P:" not in said
