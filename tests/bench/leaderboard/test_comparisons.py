"""Two agents compared: known differences and probabilities, and what has to hold whatever the numbers are."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError
from scipy.stats import bootstrap, mannwhitneyu

from hhrl_bench.errors import RecordError
from hhrl_bench.leaderboard.comparisons import PairwiseRecord, Runs, against, compare
from hhrl_envs.arrays import Floats


def pair(a: list[list[float]], b: list[list[float]], seed: int = 0) -> PairwiseRecord:
    one, other = (Runs(name, [np.array(values) for values in runs]) for name, runs in (("a", a), ("b", b)))
    return compare(one, other, "stop-line-v0", "success", np.random.default_rng(seed))


def runs(means: list[float]) -> list[list[float]]:
    """Return a run of one episode a mean."""
    return [[mean] for mean in means]


def test_means_that_do_not_vary_differ_for_sure() -> None:
    record = pair([[1, 0, 1, 1]] * 3, [[0, 0, 1, 0]] * 2)
    assert (record.agent, record.other, record.task, record.metric) == ("a", "b", "stop-line-v0", "success")
    assert (record.runs, record.other_runs, record.episodes) == (3, 2, 4)
    assert record.difference.model_dump() == {"mean": 0.5, "low": 0.5, "high": 0.5, "interval": "bootstrap-seeds"}
    assert record.probability_more is not None
    assert record.probability_more.model_dump() == {"mean": 1.0, "low": 1.0, "high": 1.0}


def test_two_runs_each_span_their_differences() -> None:
    record = pair(runs([0.0, 4.0]), runs([1.0, 2.0]))
    difference, more = record.difference, record.probability_more
    assert (difference.mean, difference.low, difference.high) == (0.5, -2.0, 3.0)
    assert more is not None
    assert (more.mean, more.low, more.high) == (0.5, 0.0, 1.0)


def test_a_single_run_stays_as_it_is_beside_several() -> None:
    record = pair(runs([1.0, 3.0]), runs([2.0]))
    assert (record.difference.mean, record.difference.low, record.difference.high) == (0.0, -1.0, 1.0)
    assert record.difference.interval == "bootstrap-seeds"
    assert record.probability_more is not None
    assert record.probability_more.mean == 0.5


def test_two_single_runs_are_paired_world_by_world() -> None:
    easy_and_hard = np.repeat([0.0, 100.0], 50)
    record = pair([[*(easy_and_hard + 1.0)]], [[*easy_and_hard]])
    assert record.difference.model_dump() == {"mean": 1.0, "low": 1.0, "high": 1.0, "interval": "bootstrap-episodes"}
    assert record.probability_more is None


def test_one_world_alone_has_no_interval() -> None:
    difference = pair([[3.0]], [[1.0]]).difference
    assert difference.model_dump() == {"mean": 2.0, "low": None, "high": None, "interval": "none"}


@pytest.mark.parametrize("flat", [[[np.nan, np.nan]], [[np.nan, np.nan]] * 3])
def test_what_an_agent_has_not_is_unknown(flat: list[list[float]]) -> None:
    for record in (pair(flat, [[1.0, 2.0]]), pair([[1.0, 2.0]], flat)):
        assert record.difference.model_dump() == {"mean": None, "low": None, "high": None, "interval": "none"}
        assert record.probability_more is None


def test_the_interval_is_scipys_two_sample_bootstrap() -> None:
    rng = np.random.default_rng(5)
    x, y = rng.normal(1.0, 1.0, 12), rng.normal(0.0, 2.0, 15)

    def difference(one: Floats, other: Floats, axis: int = -1) -> Floats:
        return np.asarray(np.mean(one, axis) - np.mean(other, axis))

    wanted = bootstrap((x, y), difference, method="percentile", rng=rng).confidence_interval
    record = pair(runs([*x]), runs([*y])).difference
    assert record.low == pytest.approx(wanted.low, abs=0.05)
    assert record.high == pytest.approx(wanted.high, abs=0.05)


def test_equal_generators_give_equal_records() -> None:
    a, b = runs([1.0, 4.0, 2.0, 8.0]), runs([3.0, 5.0, 2.5])
    assert pair(a, b) == pair(a, b)
    assert pair(a, b) != pair(a, b, seed=1)


def test_against_a_reference_agent_it_is_the_other_one() -> None:
    one = pair(runs([1.0, 4.0, 2.0]), runs([3.0, 5.0]))
    assert against("b", [one]) == [one]
    assert against("c", [one]) == []
    [turned] = against("a", [one])
    assert (turned.agent, turned.other, turned.runs, turned.other_runs) == ("b", "a", 2, 3)
    assert one.difference.low is not None
    assert turned.difference.high == -one.difference.low
    assert turned.probability_more is not None
    assert one.probability_more is not None
    assert turned.probability_more.low == 1.0 - one.probability_more.high
    [back] = against("b", [turned])
    assert back.difference == one.difference
    assert back.probability_more.mean == pytest.approx(one.probability_more.mean)  # type: ignore[union-attr]


def test_turned_round_what_is_unknown_stays_so() -> None:
    [turned] = against("a", [pair([[np.nan, np.nan]], [[1.0, 2.0]])])
    assert turned.difference.model_dump() == {"mean": None, "low": None, "high": None, "interval": "none"}
    assert turned.probability_more is None


some = st.lists(st.integers(-20, 20).map(float), min_size=1, max_size=6)


@settings(max_examples=30, deadline=None)
@given(some, some)
def test_turned_round_the_difference_is_its_negative_and_the_probability_the_rest(
    a: list[float], b: list[float]
) -> None:
    one, other = pair(runs(a), runs(b)), pair(runs(b), runs(a))
    assert one.difference.mean is not None
    assert one.difference.mean == -(other.difference.mean or 0.0)
    if one.probability_more is None or other.probability_more is None:
        assert (len(a), len(b)) == (1, 1)
        return
    assert one.probability_more.mean + other.probability_more.mean == pytest.approx(1.0)
    assert one.probability_more.mean == pytest.approx(mannwhitneyu(a, b).statistic / (len(a) * len(b)))
    assert one.probability_more.low <= one.probability_more.mean <= one.probability_more.high


@pytest.mark.parametrize("values", [[[1.0], [1.0, 2.0]], [[]]])
def test_runs_of_other_worlds_are_refused(values: list[list[float]]) -> None:
    with pytest.raises(RecordError, match=r"runs of a and b are of \[[0-9, ]+\] episodes; compare equally many"):
        pair(values, [[1.0]])


def test_an_agent_is_not_compared_to_itself() -> None:
    one = Runs("a", [np.ones(2)])
    with pytest.raises(ValidationError, match="a is compared to itself; name two agents"):
        compare(one, one, "stop-line-v0", "success", np.random.default_rng(0))
