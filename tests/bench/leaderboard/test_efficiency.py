"""Env steps to the threshold: known ones, censored ones, and the seed that is slowest."""

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from hhrl_bench.errors import CurveError
from hhrl_bench.leaderboard.efficiency import EfficiencyRecord, efficiency
from hhrl_bench.training.learning_curves import THRESHOLD
from support.trainings import STEPS, training

SOON, LATE, NEVER = (0.0, 0.93, 0.2, 0.3), (0.0, 0.9, 0.92, 1.0), (0.0, 0.9, 0.92, 0.92)


def measured(success: Sequence[Sequence[float | None]], seed: int = 0) -> EfficiencyRecord:
    return efficiency(training(success), np.random.default_rng(seed))


def test_the_first_report_at_the_threshold_counts() -> None:
    record = measured([SOON, LATE, LATE])
    assert (record.method, record.task, record.threshold) == ("ddqn", "stop-line-v0", 0.93)
    assert (record.budget, record.seeds) == (30_000, (0, 1, 2))
    assert record.steps.per_seed == (10_000, 30_000, 30_000)
    assert (record.steps.median, record.steps.reached) == (30_000, 3)
    assert (record.low, record.high) == (10_000, 30_000)
    assert (record.slowest_seed, record.slowest) == (1, 30_000)


def test_seeds_that_never_get_there_are_censored() -> None:
    record = measured([SOON, NEVER, SOON])
    assert record.steps.per_seed == (10_000, None, 10_000)
    assert (record.steps.median, record.steps.reached) == (10_000, 2)
    assert (record.low, record.high) == (10_000, None)
    assert (record.slowest_seed, record.slowest) == (1, None)


def test_where_most_never_get_there_the_median_lies_beyond_the_budget() -> None:
    record = measured([NEVER] * 5)
    assert (record.steps.median, record.steps.reached) == (None, 0)
    assert (record.low, record.high) == (30_000, None)


def test_a_seed_that_failed_counts_up_to_there() -> None:
    record = measured([(0.0, None, None, None), (0.0, 0.95, None, None), NEVER])
    assert record.steps.per_seed == (None, 10_000, None)
    assert record.slowest_seed == 0


def test_a_single_seed_has_no_interval() -> None:
    record = measured([SOON])
    assert (record.steps.median, record.low, record.high) == (10_000, None, None)


def test_curves_that_do_not_begin_at_step_0_are_refused() -> None:
    late = training([(0.5, 1.0)], env_steps=(10, 20))
    with pytest.raises(CurveError, match="write ascending ones that begin with 0"):
        efficiency(late, np.random.default_rng(0))


@pytest.mark.parametrize(
    ("change", "said"), [({"slowest_seed": 7}, "slowest seed 7 is none"), ({"seeds": (0, 1)}, "one time a seed")]
)
def test_a_record_that_contradicts_itself_is_refused(change: dict[str, object], said: str) -> None:
    data = measured([SOON]).model_dump() | change
    with pytest.raises(ValidationError, match=said):
        EfficiencyRecord.model_validate(data)


def test_a_record_is_json_and_read_back_equal() -> None:
    record = measured([SOON, NEVER])
    assert EfficiencyRecord.model_validate_json(record.model_dump_json()) == record


rates = st.lists(st.sampled_from([0.0, 0.5, THRESHOLD, 1.0]), min_size=len(STEPS), max_size=len(STEPS))


@settings(max_examples=25, deadline=None)
@given(st.lists(rates, min_size=1, max_size=5), st.data())
def test_a_seed_that_learns_more_is_never_slower(success: list[list[float]], data: st.DataObject) -> None:
    better = [[data.draw(st.sampled_from([rate, 1.0])) for rate in curve] for curve in success]
    slow, fast = measured(success), measured(better)
    late = 30_001
    for one, other in zip(slow.steps.per_seed, fast.steps.per_seed, strict=True):
        assert (late if other is None else other) <= (late if one is None else one)
    assert (fast.steps.median or 0.0) <= (late if slow.steps.median is None else slow.steps.median)
    assert (late if fast.slowest is None else fast.slowest) <= (late if slow.slowest is None else slow.slowest)
