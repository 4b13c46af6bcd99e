"""Evidence: the file of a scored policy that holds its trace and, for every episode, the whole numbers it came to.

It is a safetensors file, which the store gzips: nothing in it can execute code, and usual tools open it.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.numpy import load, save

from hhrl_bench.errors import RecordError
from hhrl_bench.evaluation.decisions import Trace
from hhrl_bench.evaluation.episodes import EpisodeRecords, TrafficRecords
from hhrl_bench.evaluation.metrics import METRICS
from hhrl_bench.evaluation.paired_evaluation import ScoredEpisodes
from hhrl_bench.evaluation.records import RunRecord
from hhrl_bench.evaluation.store import Store, read
from hhrl_envs.arrays import Keys

_INT8, _INT32 = np.dtype(np.int8), np.dtype(np.int32)


class Evidence(NamedTuple):
    """What is kept of N episodes.

    Attributes:
        trace: every decision; it also says how many steps each episode has.
        outcome: as in ``EpisodeRecords``, int8 [N].
        measured: the metrics among those of ``EpisodeRecords`` that are whole numbers, int32 [N], by their keys.
        outcomes, feasible: as in ``TrafficRecords``; int8 [N, 0] and [N] of -1 without it.
    """

    trace: Trace
    outcome: NDArray[np.int8]
    measured: Mapping[str, NDArray[np.int32]]
    outcomes: NDArray[np.int8]
    feasible: NDArray[np.int8]

    @property
    def steps(self) -> NDArray[np.int32]:
        """How many steps each episode has, int32 [N]."""
        return self.trace.steps

    def records(self, seeds: Keys) -> EpisodeRecords:
        """Return the records of the episodes, in the worlds ``seeds`` [N], as far as they follow from whole numbers."""
        if not self.outcomes.size:
            return EpisodeRecords(seeds, self.outcome, self.steps, self.measured)
        feasible = self.feasible == 1
        return TrafficRecords(seeds, self.outcome, self.steps, self.measured, feasible=feasible, outcomes=self.outcomes)


def pack(scored: ScoredEpisodes) -> bytes:
    """Return the file's content for scored episodes; equal episodes give equal bytes."""
    records = scored.records
    whole = {key: records.measured[key] for key in _whole_keys() if key in records.measured}
    arrays = {**scored.trace._asdict(), "outcome": records.outcome, **whole}
    if isinstance(records, TrafficRecords):
        arrays |= {"outcomes": records.outcomes, "feasible": records.feasible.astype(np.int8)}
    return _save(arrays)


def _save(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    return save({name: np.ascontiguousarray(array) for name, array in arrays.items()})


def _whole_keys() -> list[str]:
    """Return the keys of the metrics whose totals are whole numbers."""
    return [key for key, metric in METRICS.items() if metric.accumulation is not None and metric.is_whole]


def unpack(data: bytes) -> Evidence:
    """Return what a file's content says.

    Raises:
        RecordError: if it is damaged, or not what ``pack`` writes.
    """
    arrays = _load(data)
    known = _KNOWN.union(_whole_keys()).issuperset(arrays)
    _require(known and _save(arrays) == data, "nothing else, and all of it in one way")
    episodes = len(_array(arrays, "steps", _INT32, 1))
    trace = Trace(*(_array(arrays, name, kind, ndim) for name, kind, ndim in _TRACE))
    outcome = _array(arrays, "outcome", _INT8, 1)
    whole = {key: _array(arrays, key, _INT32, 1) for key in _whole_keys() if METRICS[key].required or key in arrays}
    outcomes, feasible = np.empty((episodes, 0), np.int8), np.full(episodes, -1, np.int8)
    if "outcomes" in arrays:
        outcomes, feasible = _array(arrays, "outcomes", _INT8, 2), _array(arrays, "feasible", _INT8, 1)
    lengths = {len(array) for array in (outcome, *whole.values(), outcomes, feasible)}
    _require(lengths == {episodes}, "a number for every episode")
    _require(episodes > 0 and int(trace.steps.min()) > 0, "a step in every episode")
    _require(len(trace.options) == len(trace.actions) == trace.steps.sum(dtype=np.int64), "a decision for every step")
    _require(trace.options.shape[1] > 0 and trace.actions.shape[1] > 0, "a vehicle")
    return Evidence(trace, outcome, whole, outcomes, feasible)


def read_evidence(run: RunRecord, store: Store) -> Evidence:
    """Return the evidence of a run whose files lie in a store.

    Raises:
        RecordError: if it is missing or damaged.
    """
    return unpack(read(store.evidence(str(run.evidence_sha256))))


MAX_HEADER_BYTES = 2**16

_TRACE = (("steps", _INT32, 1), ("options", _INT8, 2), ("actions", _INT8, 2))
_KNOWN = frozenset({"steps", "options", "actions", "outcome", "outcomes", "feasible"})


def _load(data: bytes) -> Mapping[str, NDArray[Any]]:
    length = int.from_bytes(data[:8], "little")
    _require(length <= MAX_HEADER_BYTES, f"a header of at most {MAX_HEADER_BYTES:,} bytes")
    try:
        return dict(load(data))
    except (SafetensorError, ValueError, KeyError, TypeError, MemoryError) as error:
        raise RecordError(f"no evidence: {type(error).__name__} {error}") from error


def _array(arrays: Mapping[str, NDArray[Any]], name: str, kind: np.dtype[Any], ndim: int) -> NDArray[Any]:
    array = arrays.get(name)
    _require(array is not None and array.dtype == kind and array.ndim == ndim, f"{name}, {kind} with {ndim} dimensions")
    assert array is not None
    return array


def _require(holds: bool, rule: str) -> None:
    if not holds:
        raise RecordError(f"no evidence: it has to hold {rule}")
