"""The published records: pydantic models that are the JSON schema of evaluations and leaderboards.

Records are strict (no unknown key, no coerced type), frozen, and hold finite numbers or null. All that varies between
two runs of a command (clock, machine, versions) stands in the ``provenance`` block; the rest is equal digit for digit.
"""

from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

from pydantic import ConfigDict, Field, GetJsonSchemaHandler, create_model, model_validator
from pydantic.config import JsonDict
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from hhrl_bench.evaluation.metrics import METRICS, Metric
from hhrl_bench.provenance import ProvenanceRecord
from hhrl_bench.schema import (
    FIRST,
    MAX_SEEDS,
    Count,
    Finite,
    Name,
    OptionName,
    OutcomeName,
    Positive,
    Rate,
    Record,
    Sha256,
    finite,
)
from hhrl_bench.statistics.intervals import Estimate, IntervalKind


class MetricRecord(Record):
    """A mean with its 95% interval; ``n`` counts episodes or seeds as ``interval`` says; null: the agent has none."""

    mean: Finite | None
    low: Finite | None
    high: Finite | None
    iqm: Finite | None
    n: Positive
    interval: IntervalKind


def metric_record(estimate: Estimate) -> MetricRecord:
    """Return the record of an estimate; what is not finite is null."""
    numbers = {"mean": estimate.mean, "low": estimate.low, "high": estimate.high, "iqm": estimate.iqm}
    return MetricRecord(**finite(numbers), n=estimate.n, interval=estimate.interval)


class _ByMetric(Record):
    """Values by the keys of metrics, in the order of ``METRICS``; each is an attribute too.

    Which keys there may be, and which values, say the metrics that are registered when a record is read.
    """

    model_config = ConfigDict(extra="allow")

    @classmethod
    def _type_of(cls, metric: Metric) -> Any:
        """Return the type of a metric's value."""
        raise NotImplementedError

    def declarations(self) -> list[Metric]:
        """Return the metrics that it has values of."""
        return [METRICS[key] for key in self.model_extra or {}]

    def __contains__(self, key: str) -> bool:
        return key in (self.model_extra or {})

    def get(self, key: str) -> Any:
        """Return the value of a metric; None where the record has none."""
        return (self.model_extra or {}).get(key)

    @model_validator(mode="before")
    @classmethod
    def _of_registered_metrics(cls, data: Any) -> Any:
        if isinstance(data, cls):
            return data
        for key in data if isinstance(data, Mapping) else ():
            if key not in METRICS:
                raise ValueError(
                    f"the metric {key!r} is not registered here; "
                    "load the module that registers it: hhrl-bench --extension MODULE_OR_FILE.py"
                )
        given = _model(cls, tuple(METRICS.values())).model_validate(data)
        return {key: getattr(given, key) for key in METRICS if key in given.model_fields_set}

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Return the schema with the metrics that are registered now."""
        schema = handler(_model(cls, tuple(METRICS.values())).__pydantic_core_schema__)
        return {**handler.resolve_ref_schema(schema), "description": cls.__doc__}


@cache
def _model(record: type[_ByMetric], metrics: tuple[Metric, ...]) -> type[Record]:
    """Return the model that holds such a record's values of these metrics as fields; not every entry has every one."""
    absent = Field(default=None, json_schema_extra=_without_default)
    fields: dict[str, Any] = {
        metric.key: (record._type_of(metric), ... if metric.required else absent)  # noqa: SLF001
        for metric in metrics
    }
    return create_model(record.__name__, __base__=Record, __doc__=record.__doc__, **fields)


def _without_default(schema: JsonDict) -> None:
    schema.pop("default", None)


class MetricsRecord(_ByMetric):
    """The metrics of a result, by key: the task's reward, the columns of Table I, how severe it got."""

    __pydantic_extra__: dict[str, MetricRecord]

    if TYPE_CHECKING:

        def __getattr__(self, key: str) -> MetricRecord:
            """Return the value of a metric."""

    @classmethod
    def _type_of(cls, _: Metric) -> Any:
        return MetricRecord


class RunMetricsRecord(_ByMetric):
    """The means over the episodes of one run that have the number; null: none has."""

    __pydantic_extra__: dict[str, Finite | None]

    if TYPE_CHECKING:

        def __getattr__(self, key: str) -> Any:
            """Return the mean of a metric."""

    @classmethod
    def _type_of(cls, metric: Metric) -> Any:
        kind: Any = Rate if metric.is_rate else Finite
        return kind | None if metric.nullable else kind


Kind = Literal["rule", "oracle", "learned", "factory"]
"""What an agent is: a rule, one that knows the future, a learned one, or a user's own code."""


MAX_BUDGET = 100_000_000
"""Env steps of a training."""


class TrainingRecord(Record):
    """Where a checkpoint comes from: ``env_steps`` done when it was taken, of a budget of ``budget`` steps on ``task``.

    ``exact``: the same training leaves the same file on every processor. ``command`` trains this seed again; that of an
    ``arm`` of a transfer is None, and ``source_sha256`` the checkpoint that it began with, None: it began from nothing.
    """

    seed: Count
    method: Name
    config_hash: Name
    scenario: Name
    spec_hash: Sha256
    task: Name | None
    env_steps: Count
    budget: Annotated[int, Field(ge=1, le=MAX_BUDGET)] | None
    exact: bool
    command: Name | None
    arm: Name | None = None
    source_sha256: Sha256 | None = None


class RunTrafficRecord(Record):
    """Episodes of a run with learned front vehicles: the feasible ones, the successes among them, and every vehicle's.

    ``vehicles`` counts how often the episode of a vehicle had each outcome, the ego first; infeasible ones count too.
    """

    feasible: Count
    success_feasible: Count
    vehicles: Annotated[tuple[dict[OutcomeName, Count], ...], FIRST]


class TrafficRecord(Record):
    """In a world with learned front vehicles: the share of feasible episodes, and that of successes among them."""

    feasible: MetricRecord
    success_feasible: MetricRecord


class RunRecord(Record):
    """One evaluated policy: the only one of a rule, or one training seed of a learned method.

    ``evidence_sha256`` and ``checkpoint_sha256`` name files of the store beside the leaderboard; ``episodes_sha256`` is
    the digest of the episodes' records.
    """

    checkpoint_sha256: Sha256 | None
    training: TrainingRecord | None
    evidence_sha256: Sha256 | None
    episodes_sha256: Sha256
    metrics: RunMetricsRecord
    traffic: RunTrafficRecord | None = None


class ResultRecord(Record):
    """One agent on one task: its runs and what they come to; ``failed_seeds`` failed in training and have no run."""

    agent: Name
    kind: Kind
    task: Name
    option: OptionName | None
    runs: Annotated[tuple[RunRecord, ...], FIRST, Field(min_length=1, max_length=MAX_SEEDS)]
    failed_seeds: Annotated[tuple[Count, ...], FIRST, Field(max_length=MAX_SEEDS)] = ()
    metrics: MetricsRecord
    traffic: TrafficRecord | None = None

    @property
    def seeds(self) -> tuple[int, ...]:
        """The training seeds of the runs; none for agents that are not trained."""
        return tuple(run.training.seed for run in self.runs if run.training)


class TimedResult(Record):
    """A result, and the seconds it took."""

    result: ResultRecord
    seconds: Annotated[float, Field(allow_inf_nan=False, ge=0.0)]


class TrainedSeed(NamedTuple):
    """A seed that was trained: the seconds it took, and a word about it."""

    seconds: float
    note: str


class OpponentRecord(Record):
    """The agent that drives the nearest front vehicle."""

    agent: Name
    checkpoint_sha256: Sha256 | None


class TaskRecord(Record):
    """A task as it was played: test episode i is the world of seed ``test_start + i``.

    ``golden_digest`` is that of the scenario's trajectories; the worlds of training and validation begin at
    ``train_start`` and ``validation_start``. ``shared``: one policy drove all vehicles, and success means that all have
    succeeded.
    """

    id: Name
    scenario: Name
    spec_hash: Sha256
    interface_hash: Sha256
    golden_digest: Sha256
    env_steps: Positive
    train_start: Count
    validation_start: Count
    test_start: Count
    episodes: Positive
    shared: bool = False
    opponent: OpponentRecord | None = None


class EvaluationRecord(Record):
    """What ``hhrl-bench evaluate --json`` prints: every agent that was named, in the same worlds."""

    schema_version: Literal[1]
    confidence: Rate
    bootstrap_seed: Count
    task: TaskRecord
    results: Annotated[tuple[ResultRecord, ...], FIRST, Field(min_length=1)]
    provenance: ProvenanceRecord
