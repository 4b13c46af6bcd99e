"""What a metric is, how it comes up over the steps of episodes, and the registry of all metrics."""

import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, Protocol, get_args

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from hhrl_envs.arrays import Codes, Flags, Floats, Floats32, Ints
from hhrl_envs.errors import InputError

if TYPE_CHECKING:
    from hhrl_bench.evaluation.rollout import Rollout, Step

RESERVED = frozenset({"seed", "outcome", "feasible", "outcomes", "options", "actions", "declarations", "get"})
"""Words that are no keys of metrics, as records have them already."""


class Ending(Protocol):
    """How N episodes ended."""

    @property
    def outcome(self) -> Codes:
        """Codes of :class:`hhrl_envs.Outcome`, int8 [N]."""

    @property
    def steps(self) -> NDArray[np.int32]:
        """Environment steps, int32 [N]."""


class Measured(Ending, Protocol):
    """How N episodes ended, and what came up over their steps."""

    @property
    def measured(self) -> Mapping[str, NDArray[Any]]:
        """The totals [N] of metrics, by their keys."""


class Accumulation(Protocol):
    """How a metric comes up over the steps of B episodes that are run side by side.

    whole: whether the totals are whole numbers, which the evidence of a result keeps.
    """

    @property
    def whole(self) -> bool:
        """Whether the totals are int32, else they are float64."""

    def start(self, rollout: "Rollout") -> NDArray[Any] | None:
        """Return the totals [rows] before the first step; None where the metric has no meaning in these worlds."""

    def add(self, totals: NDArray[Any], step: "Step") -> None:
        """Add a step, of the first vehicle that the agent drives in every row, to the totals [rows]."""


@dataclass(frozen=True)
class Sum:
    """The sum of ``of``, numbers or truth values [B] of a step, over the steps in which an episode runs."""

    of: Callable[["Step"], Floats | Floats32 | Ints | Flags]
    whole: bool = False

    def start(self, rollout: "Rollout") -> NDArray[Any]:
        """Return zeros, int32 or float64 [rows]."""
        return np.zeros(len(rollout.seeds), np.int32 if self.whole else np.float64)

    def add(self, totals: NDArray[Any], step: "Step") -> None:
        """Add a step to the totals [rows]."""
        values = np.asarray(self.of(step))
        _require_shape(values, totals.shape)
        if self.whole and values.dtype.kind not in "biu":
            raise InputError(f"returned {values.dtype} values; return whole numbers, or leave out whole=True")
        np.add(totals, values, out=totals, where=step.running, casting="unsafe")


@dataclass(frozen=True)
class Least:
    """The least of ``of``, float64 [B] of a step, over the steps in which an episode runs; NaN where there is none."""

    of: Callable[["Step"], Floats]
    whole: bool = False

    def start(self, rollout: "Rollout") -> NDArray[Any]:
        """Return NaN, float64 [rows]."""
        return np.full(len(rollout.seeds), np.nan)

    def add(self, totals: NDArray[Any], step: "Step") -> None:
        """Add a step to the totals [rows]."""
        values = np.asarray(self.of(step))
        _require_shape(values, totals.shape)
        np.fmin(totals, values, out=totals, where=step.running)


@dataclass(frozen=True)
class OfWorld:
    """What ``of`` says of the worlds of a rollout before the first step, whole numbers [B], whoever drives there.

    It is None where it has no meaning in them.
    """

    of: Callable[["Rollout"], Ints | None]
    whole: bool = True

    def start(self, rollout: "Rollout") -> NDArray[Any] | None:
        """Return the numbers, int32 [rows]."""
        numbers = self.of(rollout)
        return None if numbers is None else numbers.astype(np.int32)

    def add(self, totals: NDArray[Any], step: "Step") -> None:
        """Leave the numbers as they are."""


TableName = Literal["results", "score", "worst cases"]


@dataclass(frozen=True)
class Metric:
    """A number of every episode; a result has its mean.

    Attributes:
        key: its name in files, such as ``"smallest_gap"``.
        heading: what stands above its column; a line end in it is one in narrow columns.
        of: how it comes up over the steps, or a function of how episodes ended and of the metrics that it ``needs``.
        meaning: what it is, in a sentence.
        unit: its unit; empty where it has none.
        digits, bound_digits: after the point of means, and of the bounds of intervals, in tables.
        better: whether more or less of it is better; None: neither.
        is_rate: whether it is 0 or 1 in every episode; tables show the mean in percent.
        nullable: whether it is NaN in some episodes, which then do not count; in files, the mean of none is null.
        required: whether every entry has it; a metric that is younger than some entries cannot be.
        watched: whether trainings report it of validation episodes.
        compared: whether entries compare every two agents by it; only if it is whole.
        table: the table that it is a column of: the results, the parts of the score, or the worst cases; None: of none.
        needs: the metrics of whole numbers, by their keys, that ``of`` reads if it is a function.
    """

    key: str
    heading: str
    of: Accumulation | Callable[[Any], Floats]
    meaning: str
    unit: str = ""
    digits: int = 2
    bound_digits: int = 2
    better: Literal["higher", "lower"] | None = None
    is_rate: bool = False
    nullable: bool = True
    required: bool = False
    watched: bool = False
    compared: bool = False
    table: TableName | None = "results"
    needs: tuple[str, ...] = ()

    @property
    def accumulation(self) -> Accumulation | None:
        """How it comes up over the steps; None: it follows from how the episodes ended."""
        return None if callable(self.of) else self.of

    @property
    def is_whole(self) -> bool:
        """Whether an episode's value follows from the whole numbers that the evidence of a result keeps."""
        return callable(self.of) or self.of.whole

    def follows_from(self, measured: Iterable[str]) -> bool:
        """Return whether its numbers follow from how episodes ended and the totals of metrics with these keys."""
        return {*(self.needs if callable(self.of) else (self.key,))} <= {*measured}

    def values(self, records: Measured) -> Floats:
        """Return the numbers of N episodes, float64 [N]; NaN in those that have none.

        Raises:
            InputError: if the episodes lack it, or a function of how they ended raises, or returns another number of
                values.
        """
        if not callable(self.of):
            if self.key not in records.measured:
                raise InputError(f"the episodes have no {self.key!r}")
            return np.asarray(records.measured[self.key], np.float64)
        try:
            values = np.asarray(self.of(records), np.float64)
            _require_shape(values, records.outcome.shape)
        except Exception as error:
            raise metric_error(self.key, error) from error
        return values


def metric_error(key: str, error: Exception) -> InputError:
    """Return the error, in one line that names the metric, to raise in place of one of its function."""
    why = str(error) if isinstance(error, InputError) else f"raised {type(error).__name__}: {error}"
    return InputError(f"the function of metric {key!r} {why}")


def _require_shape(values: NDArray[Any], shape: tuple[int, ...]) -> None:
    if values.shape != shape or values.dtype.kind not in "biuf":
        raise InputError(f"returned {values.dtype} values of shape {values.shape}; return numbers of shape {shape}")


_by_key: dict[str, Metric] = {}

METRICS: Mapping[str, Metric] = MappingProxyType(_by_key)
"""All metrics by their keys, in the order of files; ``metrics`` declares ours, those of users come last."""


def register_metric(metric: Metric) -> Metric:
    """Make a metric known by its key to all commands, and return it.

    Raises:
        InputError: if the key is none, or is taken.
    """
    if not isinstance(metric, Metric):
        raise InputError(f"cannot register {metric!r} as a metric; give a hhrl_bench.Metric")
    key = metric.key
    if metric.better not in {"higher", "lower", None} or metric.table not in {*get_args(TableName), None}:
        tables = ", ".join(map(repr, get_args(TableName)))
        allowed = f"better 'higher', 'lower' or None, and table {tables} or None"
        raise InputError(f"metric {key!r} has better={metric.better!r} and table={metric.table!r}; write {allowed}")
    if not callable(metric.of) and not callable(getattr(metric.of, "add", None)):
        raise InputError(f"metric {key!r} has of={metric.of!r}; write Sum, Least or a function of how episodes end")
    if not re.fullmatch(r"[a-z][a-z0-9_]*", key) or key in RESERVED or hasattr(BaseModel, key):
        raise InputError(f"a metric cannot have the key {key!r}; write another word, such as 'stop_error'")
    if _by_key.get(key, metric) != metric:
        raise InputError(f"there is a metric {key!r} already; write another key")
    if metric.compared and not metric.is_whole:
        raise InputError(f"metric {key!r} cannot be compared: no evidence of a result keeps its values")
    _by_key[key] = metric
    return metric


def watched() -> list[Metric]:
    """Return the metrics that trainings report of validation episodes."""
    return [metric for metric in METRICS.values() if metric.watched]


def compared() -> list[Metric]:
    """Return the metrics by which entries compare every two agents."""
    return [metric for metric in METRICS.values() if metric.compared]


def columns(table: TableName) -> tuple[Metric, ...]:
    """Return the metrics that are columns of a table; the rates come last, as in the paper's Table I."""
    chosen = [metric for metric in METRICS.values() if metric.table == table]
    return tuple(sorted(chosen, key=lambda metric: metric.is_rate))


def known_metrics(records: Measured) -> list[Metric]:
    """Return the metrics whose numbers follow from records."""
    return [metric for metric in METRICS.values() if metric.follows_from(records.measured)]


def means(records: Measured, metrics: Iterable[Metric] | None = None) -> dict[str, float]:
    """Return the mean of every metric over the episodes that have it, NaN where none has; by default of all known."""
    chosen = known_metrics(records) if metrics is None else metrics
    return {one.key: mean(one.values(records)) for one in chosen}


def mean(values: Floats) -> float:
    """Return the mean of the values that are not NaN; NaN if all are."""
    known = values[~np.isnan(values)]
    return float(np.mean(known)) if known.size else math.nan
