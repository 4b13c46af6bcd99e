"""What an analysis says, as records: an episode, the (d_f, d_d) plane, option usage and per-level rewards.

State elements are keyed by their symbols (``hhrl_envs.observation.SYMBOLS``) and given in SI units.
"""

from collections.abc import Mapping
from typing import Annotated, Literal, TypeVar

import numpy as np
from pydantic import Field

from hhrl_bench.evaluation.records import Kind, TaskRecord, TrainingRecord
from hhrl_bench.schema import Count, Finite, Name, OptionName, OutcomeName, Positive, Rate, Record, Sha256
from hhrl_envs import Outcome
from hhrl_envs.arrays import Floats, Floats32

LevelName = Literal["option", "action", "task"]
TermName = Literal["sub_goal", "unsafe", "failure", "jerk"]

Key = TypeVar("Key")
Value = TypeVar("Value")
Series = tuple[Finite, ...]
Grid = tuple[Series, ...]
Shares = dict[OptionName, Rate]
Weights = dict[str, Finite]


class EpisodeTraceRecord(Record):
    """Test episode ``number``, step by step; null where the agent has no options or no attention.

    ``time`` [s] and ``state`` are those in which the step was decided on. ``cumulative`` sums ``reward``, both of the
    selected option; a flat agent has r^task alone.
    """

    number: Count
    seed: Count
    outcome: OutcomeName
    time: Series
    state: dict[str, Series]
    option: tuple[OptionName, ...] | None
    action: tuple[Count, ...]
    attention: dict[str, Series] | None
    reward: dict[LevelName, Series]
    cumulative: dict[LevelName, Series]


class PlaneRecord(Record):
    """Greedy option and action level, and attention by option, at every (d_d, d_f) [m]; rows are those of ``d_d``."""

    v_e: Finite
    v_f: Finite
    d_f: Series
    d_d: Series
    option: tuple[tuple[OptionName, ...], ...] | None
    action: tuple[tuple[Count, ...], ...]
    attention: dict[OptionName, dict[str, Grid]] | None


class UsageRecord(Record):
    """Shares of the steps by option, and how often an episode switches between options, on the average."""

    episodes: Positive
    steps: Positive
    switches: Finite
    share: Shares


class UsageBinRecord(Record):
    """The steps with a distance in [low, high) metres, ``high`` null: out of range; without steps no shares."""

    low: Finite
    high: Finite | None
    steps: Count
    share: Shares | None


class OptionUsageRecord(Record):
    """Which option is selected: in all steps, by the episode's outcome, by distance to line and front vehicle."""

    overall: UsageRecord
    by_outcome: dict[OutcomeName, UsageRecord]
    by_d_d: tuple[UsageBinRecord, ...]
    by_d_f: tuple[UsageBinRecord, ...]


class LevelRecord(Record):
    """Means over episodes of a level's return, and of the sums of its reward terms, which add up to it."""

    total: Finite
    terms: dict[TermName, Finite]


class LevelsRecord(Record):
    """A number of episodes and the rewards of every level; a flat agent has the level ``task`` alone."""

    episodes: Positive
    levels: dict[LevelName, LevelRecord]


class EpisodeRewardsRecord(Record):
    """Every episode's outcome, returns, and sums of reward terms, level by level."""

    outcome: tuple[OutcomeName, ...]
    total: dict[LevelName, Series]
    terms: dict[LevelName, dict[TermName, Series]]


class StepRewardsRecord(Record):
    """Mean rewards of the episodes that are still ``running`` at step 0, 1, 2, ..."""

    running: tuple[Positive, ...]
    reward: dict[LevelName, Series]


class LevelRewardsRecord(Record):
    """Per-level rewards: means, means by outcome, every episode, every step index."""

    overall: LevelsRecord
    by_outcome: dict[OutcomeName, LevelsRecord]
    by_episode: EpisodeRewardsRecord
    by_step: StepRewardsRecord


class AnalysisRecord(Record):
    """What ``hhrl-bench analyse`` prints and writes; ``attention`` holds mean weights by selected option.

    ``levels`` are the target accelerations [m/s^2] that the actions stand for. Null: the agent has no such thing.
    """

    schema_version: Literal[1]
    agent: Name
    kind: Kind
    checkpoint_sha256: Sha256 | None
    training: TrainingRecord | None
    task: TaskRecord
    levels: Annotated[Series, Field(min_length=2)]
    episode: EpisodeTraceRecord
    plane: PlaneRecord
    option_usage: OptionUsageRecord | None
    level_rewards: LevelRewardsRecord
    attention: dict[OptionName, Weights] | None


def outcome_name(code: int) -> OutcomeName:
    """Return how the records spell an ego's outcome (:class:`hhrl_envs.Outcome`)."""
    return Outcome(code).name.lower()


def named(record: AnalysisRecord) -> str:
    """Return what was analysed where: agent, training seed if any, task."""
    seed = f", training seed {record.training.seed}," if record.training else ""
    return f"{record.agent}{seed} on {record.task.id}"


def decimals(values: Floats32) -> Floats:
    """Return the numbers as float64 of the fewest decimal digits that name the same float32: short in JSON."""
    return values.astype(np.str_).astype(np.float64)


def spoken(outcome: OutcomeName) -> str:
    """Return an outcome as text shows it."""
    return outcome.replace("_", " ")


def shown(levels: Mapping[LevelName, Value]) -> dict[LevelName, Value]:
    """Return the levels to show: option and action level, or r^task of a flat agent."""
    return {level: value for level, value in levels.items() if level != "task" or len(levels) == 1}


def grouped(overall: Value, by_outcome: Mapping[OutcomeName, Value]) -> dict[str, Value]:
    """Return what holds of all episodes, then what holds of those of each outcome, by names as text shows them."""
    return {"all": overall, **{spoken(outcome): value for outcome, value in by_outcome.items()}}


def series(columns: Mapping[Key, Floats]) -> dict[Key, Series]:
    """Return the columns, float64 [n] each, as tuples of numbers."""
    return {key: tuple(column.tolist()) for key, column in columns.items()}
