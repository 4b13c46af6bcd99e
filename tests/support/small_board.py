"""A small leaderboard that holds something of everything, for tests of what becomes of changed and damaged entries."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hhrl_bench.evaluation.episodes import EpisodeRecords
from hhrl_bench.evaluation.evidence import Evidence, pack
from hhrl_bench.evaluation.paired_evaluation import ScoredEpisodes
from hhrl_bench.evaluation.records import ResultRecord, TimedResult
from hhrl_bench.evaluation.results import task_record
from hhrl_bench.evaluation.store import Store
from hhrl_bench.leaderboard import comparisons
from hhrl_bench.leaderboard.entry import build_entry, publish_entry
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.statistics import censored_times, intervals
from hhrl_bench.suites.units import Evaluation, OutcomeRecord
from hhrl_bench.tasks.tasks import get_task
from hhrl_bench.training.learning_curves import TrainingOutcomesRecord
from hhrl_bench.transfer.records import TransferSetRecord
from hhrl_bench.transfer.summary import ArmCurves, TransferCurves, transfer_set
from hhrl_bench.transfer.transfer import ArmName
from support.trainings import training

EPISODES = 6
PAIRS = (
    ("rule-2", "stop-line-v0"),
    ("ddqn", "stop-line-v0"),
    ("rule-2", "platoon-v0"),
    ("platoon", "platoon-v0"),
    ("rule-2", "adversary-v0"),
    ("follow-only", "adversary-v0"),
)
CURVES = {
    ("ddqn", "stop-line-v0"): [[0.0, 0.95, 0.5, 0.9], [0.1, 0.25, 0.8, 0.93], *[[0.0, 0.25, 0.9, 0.95]] * 3],
    ("platoon", "platoon-v0"): [[0.0, 0.1, 0.3, 0.94]] * 3,
}


def publish(folder: Path, pairs: Sequence[tuple[str, str]] = PAIRS) -> Path:
    """Return the path of the leaderboard of these agents and tasks, published into ``folder/published``."""
    store = Store(folder)
    done = [Evaluation(agent, get_task(task), EPISODES, folder).run() for agent, task in pairs]
    tasks = [task_record(get_task(task), EPISODES) for task in dict.fromkeys(task for _, task in pairs)]
    trainings = [_training(one.result) for one in done if (one.result.agent, one.result.task) in CURVES]
    board = build_entry("small", tasks, done, "make it", store, trainings=trainings)
    path = folder / "published" / "small.json"
    path.parent.mkdir()
    publish_entry(board, path, store)
    return path


def _training(result: ResultRecord) -> TrainingOutcomesRecord:
    """Return a training with reports where the checkpoints of a result were taken."""
    success = CURVES[result.agent, result.task]
    steps = sorted({0, *(run.training.env_steps for run in result.runs if run.training)})
    steps += [steps[-1] + 1 + more for more in range(len(success[0]) - len(steps))]
    return training(success, result.agent, result.task, steps)


def outcome(path: Path) -> TimedResult:
    """Return the outcome in the file of a unit that was done."""
    return OutcomeRecord.model_validate_json(path.read_bytes()).outcome


def with_transfer(board: LeaderboardRecord) -> LeaderboardRecord:
    """Return a leaderboard as that of a transfer, whose checkpoints are not published."""
    return board.model_copy(update={"transfer": _transfer(), "checkpoints_published": False, "methods": ()})


def _transfer() -> TransferSetRecord:
    steps, seeds = (0, 100, 200), (0, 2)
    arms: dict[ArmName, ArmCurves] = {
        "scratch": ArmCurves(seeds, steps, ((0.0, 0.25, 0.95), (0.0, 0.3, 0.5))),
        "frozen-action": ArmCurves(seeds, steps, ((0.5, 0.95, 1.0), (0.25, 0.75, 0.94))),
        "zero-shot": ArmCurves(seeds, (0,), ((0.5,), (0.25,))),
    }
    return transfer_set([TransferCurves("stop-line-v0", "stop-and-go-v0", "hybrid-hrl", arms)])


NOT_KEPT = ("return_task", "return_option", "return_action", "unsafe", "impact_speed", "smallest_gap", "smallest_ttc")


def repacked(kept: Evidence) -> bytes:
    """Return the content of an evidence file that holds this evidence."""
    measured: dict[str, Any] = {**kept.measured, **dict.fromkeys(NOT_KEPT, np.empty(0))}
    records = EpisodeRecords(np.empty(0, np.uint64), kept.outcome, kept.trace.steps, measured)
    return pack(ScoredEpisodes(records, kept.trace))


@contextmanager
def resamples(count: int) -> Iterator[None]:
    """Return a context in which intervals come from so few resamples."""
    with pytest.MonkeyPatch.context() as patch:
        for module in (intervals, comparisons, censored_times):
            patch.setattr(module, "RESAMPLES", count)
        yield
