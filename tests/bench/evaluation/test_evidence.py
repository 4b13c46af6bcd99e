"""Evidence: what is packed is unpacked, equal episodes give equal bytes, and everything else is refused in one line."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from safetensors.numpy import save

from hhrl_bench.errors import RecordError
from hhrl_bench.evaluation.decisions import Trace
from hhrl_bench.evaluation.episodes import EpisodeRecords, TrafficRecords
from hhrl_bench.evaluation.evidence import pack, unpack
from hhrl_bench.evaluation.paired_evaluation import ScoredEpisodes


@st.composite
def episodes(draw: st.DrawFn) -> ScoredEpisodes:
    """A few episodes of any length, with learned front vehicles or without."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    steps = np.array(draw(st.lists(st.integers(1, 9), min_size=1, max_size=6)), np.int32)
    rows, n, vehicles, slots = int(steps.sum()), len(steps), draw(st.integers(1, 4)), draw(st.integers(1, 4))
    trace = Trace(steps, rng.integers(-1, 2, (rows, slots), np.int8), rng.integers(0, 6, (rows, vehicles), np.int8))
    names = ("return_task", "return_option", "return_action", "unsafe", "impact_speed", "smallest_gap", "smallest_ttc")
    common: dict[str, Any] = {
        "seed": np.arange(n, dtype=np.uint64),
        "outcome": rng.integers(1, 5, n, np.int8),
        "steps": steps,
        "measured": {"unsmooth": rng.integers(0, 9, n, np.int32), **dict.fromkeys(names, np.zeros(n))},
    }
    if not draw(st.booleans()):
        return ScoredEpisodes(EpisodeRecords(**common), trace)
    feasible, outcomes = rng.random(n) < 0.5, rng.integers(1, 7, (n, vehicles), np.int8)
    return ScoredEpisodes(TrafficRecords(**common, feasible=feasible, outcomes=outcomes), trace)


@given(episodes())
@settings(deadline=None, max_examples=50)
def test_what_is_packed_is_unpacked(played: ScoredEpisodes) -> None:
    data, records = pack(played), played.records
    assert pack(played) == data
    kept = unpack(data)
    for name, theirs in played.trace._asdict().items():
        ours = getattr(kept.trace, name)
        np.testing.assert_array_equal(ours, theirs)
        assert np.asarray(ours).dtype == np.asarray(theirs).dtype
    np.testing.assert_array_equal(kept.outcome, records.outcome)
    np.testing.assert_array_equal(kept.measured["unsmooth"], records.unsmooth)
    if isinstance(records, TrafficRecords):
        np.testing.assert_array_equal(kept.outcomes, records.outcomes)
        np.testing.assert_array_equal(kept.feasible, records.feasible)
    else:
        assert kept.outcomes.size == 0


ARRAYS: dict[str, NDArray[Any]] = {
    "steps": np.array([2, 1], np.int32),
    "options": np.zeros((3, 1), np.int8),
    "actions": np.zeros((3, 2), np.int8),
    "outcome": np.ones(2, np.int8),
    "unsmooth": np.zeros(2, np.int32),
    "outcomes": np.ones((2, 2), np.int8),
    "feasible": np.ones(2, np.int8),
}


def content(**changes: NDArray[Any] | None) -> bytes:
    """Return a file with these arrays in place of others; None takes one out."""
    arrays = {name: array for name, array in (ARRAYS | changes).items() if array is not None}
    return save(arrays)


def refused(data: bytes) -> str:
    with pytest.raises(RecordError) as caught:
        unpack(data)
    assert len(str(caught.value).splitlines()) == 1
    return str(caught.value)


def test_the_arrays_by_themselves_are_evidence() -> None:
    assert unpack(content()).trace.steps.tolist() == [2, 1]


@pytest.mark.parametrize("name", sorted(set(ARRAYS) - {"outcomes"}))
def test_no_array_may_be_missing(name: str) -> None:
    assert name in refused(content(**{name: None}))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"steps": np.array([2, 1], np.int64)}, "steps, int32 with 1 dimensions"),
        ({"steps": np.array([[2, 1]], np.int32)}, "steps, int32 with 1 dimensions"),
        ({"steps": np.array([2, 2], np.int32)}, "a decision for every step"),
        ({"steps": np.array([3, 0], np.int32)}, "a step in every episode"),
        ({"steps": np.array([-1, 4], np.int32)}, "a step in every episode"),
        ({"steps": np.array([2**31 - 1, 2**31 - 1], np.int32)}, "a decision for every step"),
        ({"options": np.zeros((3, 0), np.int8)}, "a vehicle"),
        ({"actions": np.zeros((2, 2), np.int8)}, "a decision for every step"),
        ({"outcome": np.ones(3, np.int8)}, "a number for every episode"),
        ({"unsmooth": np.zeros(1, np.int32)}, "a number for every episode"),
        ({"outcomes": np.ones((1, 2), np.int8)}, "a number for every episode"),
        ({"outcomes": np.ones(2, np.int8)}, "outcomes, int8 with 2 dimensions"),
        (
            {name: np.zeros((0, *array.shape[1:]), array.dtype) for name, array in ARRAYS.items()},
            "a step in every episode",
        ),
    ],
)
def test_arrays_that_do_not_go_together_are_refused(changes: dict[str, NDArray[Any]], said: str) -> None:
    assert said in refused(content(**changes))


def test_what_is_no_whole_file_is_refused() -> None:
    data = content()
    for other in (b"", data[:-1], data[: len(data) // 2], data + b"\0", data + data):
        refused(other)
