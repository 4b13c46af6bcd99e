"""Leaderboards of made-up means, for tests of figures; they hold no more than a figure looks at."""

from collections.abc import Sequence
from typing import Any

from hhrl_bench.evaluation.metrics import METRICS
from hhrl_bench.evaluation.records import MetricRecord, MetricsRecord, ResultRecord, TaskRecord
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.paper_table import TABLE_I
from hhrl_bench.schema import OptionName
from hhrl_bench.tasks.tasks import get_task
from hhrl_bench.training.learning_curves import TrainingOutcomesRecord

EPISODES = 1000


def result(
    agent: str, task: str = "stop-line-v0", option: OptionName | None = None, **means: float | None
) -> ResultRecord:
    """Return a result with these means, 0 where none is given, each in an interval of 0.1 more and less."""
    metrics: dict[str, Any] = {key: _metric(means.get(key, 0.0)) for key in METRICS}
    made = MetricsRecord.model_construct(None, **metrics)
    return ResultRecord.model_construct(agent=agent, kind="rule", task=task, option=option, runs=(), metrics=made)


def _metric(mean: float | None) -> MetricRecord:
    low, high = (None, None) if mean is None else (mean - 0.1, mean + 0.1)
    return MetricRecord(mean=mean, low=low, high=high, iqm=None, n=EPISODES, interval="bootstrap-episodes")


def board(results: Sequence[ResultRecord], trainings: Sequence[TrainingOutcomesRecord] = ()) -> LeaderboardRecord:
    """Return the leaderboard of these results and trainings, and of all their tasks."""
    ids = dict.fromkeys([*(one.task for one in results), *(one.task for one in trainings)])
    tasks = [TaskRecord.model_construct(id=task, scenario=get_task(task).scenario, episodes=EPISODES) for task in ids]
    return LeaderboardRecord.model_construct(
        suite="quick", tasks=tuple(tasks), results=tuple(results), transfer=None, trainings=tuple(trainings)
    )


def rules() -> list[ResultRecord]:
    """Return a result of each policy of Table I, no two of them alike."""
    return [
        result(row.counterpart, steps=100.0 + i, unsmooth=5.0 - i, success=0.95 - 0.1 * i, collision=0.1 * i)
        for i, row in enumerate(TABLE_I)
    ]
