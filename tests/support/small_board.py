"""A small leaderboard that holds something of everything, for tests of what becomes of changed and damaged entries."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hhrl_agents import METHODS
from hhrl_bench.evaluation.episodes import EpisodeRecords
from hhrl_bench.evaluation.evidence import Evidence, pack
from hhrl_bench.evaluation.paired_evaluation import ScoredEpisodes
from hhrl_bench.evaluation.records import ResultRecord, TimedResult
from hhrl_bench.evaluation.results import task_record
from hhrl_bench.evaluation.store import Store
from hhrl_bench.leaderboard import comparisons
from hhrl_bench.leaderboard.entry import build_entry, publish_entry
from hhrl_bench.leaderboard.record import LeaderboardRecord, derived_fields
from hhrl_bench.schema import sha256_of
from hhrl_bench.statistics import censored_times, intervals
from hhrl_bench.suites.units import Evaluation, OutcomeRecord
from hhrl_bench.tasks.tasks import get_task
from hhrl_bench.training.learning_curves import TRAINING_OUTCOMES, SharesRecord, TrainingOutcomesRecord
from hhrl_bench.transfer.records import TransferSetRecord
from hhrl_bench.transfer.summary import ArmCurves, TransferCurves, transfer_set
from hhrl_bench.transfer.transfer import ArmName, target_method
from support.trainings import training

EPISODES = 6
BUDGET = 3200
"""Env steps of the arms of a transfer."""

PAIRS = (
    ("rule-2", "stop-line-v0"),
    ("ddqn", "stop-line-v0"),
    ("rule-2", "platoon-v0"),
    ("platoon", "platoon-v0"),
    ("rule-2", "adversary-v0"),
    ("follow-only", "adversary-v0"),
)
TRAINED = PAIRS[1], PAIRS[3]
"""Those with learning curves."""


def publish(folder: Path, pairs: Sequence[tuple[str, str]] = PAIRS) -> Path:
    """Return the path of the leaderboard of these agents and tasks, published into ``folder/published``."""
    store = Store(folder)
    done = [Evaluation(agent, get_task(task), EPISODES, folder).run() for agent, task in pairs]
    tasks = [task_record(get_task(task), EPISODES) for task in dict.fromkeys(task for _, task in pairs)]
    trainings = [_training(one.result, store) for one in done if (one.result.agent, one.result.task) in TRAINED]
    board = build_entry("small", tasks, done, "make it", store, trainings=trainings)
    path = folder / "published" / "small.json"
    path.parent.mkdir()
    publish_entry(board, path, store)
    return path


def _training(result: ResultRecord, store: Store) -> TrainingOutcomesRecord:
    """Return a training that times out but where the checkpoints of a result were taken, as they say."""
    known = [one.training for one in result.runs if one.training]
    steps = sorted({0, *(one.env_steps for one in known), *(one.budget or 0 for one in known)})
    said = [store.checkpoint_metadata(str(run.checkpoint_sha256))["validation"] for run in result.runs]
    reports = [steps.index(one.env_steps) for one in known]
    made = training([[0.0] * len(steps)] * len(known), result.agent, result.task, steps)
    testing = {
        outcome: tuple(
            (*curve[:report], of_run[outcome], *curve[report + 1 :])
            for curve, report, of_run in zip(getattr(made.testing, outcome), reports, said, strict=True)
        )
        for outcome in TRAINING_OUTCOMES
    }
    return made.model_copy(update={"testing": SharesRecord(**testing)})


def outcome(path: Path) -> TimedResult:
    """Return the outcome in the file of a unit that was done."""
    return OutcomeRecord.model_validate_json(path.read_bytes()).outcome


def with_transfer(board: LeaderboardRecord, store: Store) -> LeaderboardRecord:
    """Return a leaderboard as that of a transfer of its first learned agent, whose checkpoints are not published."""
    rule, source, *_ = board.results
    results = [rule, source, *(_arm(source, arm) for arm in ("zero-shot", "fine-tune", "scratch"))]
    seconds = {f"{one.task}/{one.agent}": 1.0 for one in results}
    return board.model_copy(
        update={
            "results": tuple(results),
            "transfer": _transfer(source),
            "checkpoints_published": False,
            **derived_fields(results, board.trainings[:1], store, checkpoints=False),
            "trainings": board.trainings[:1],
            "provenance": board.provenance.model_copy(update={"wall_seconds": seconds}),
        }
    )


def _arm(source: ResultRecord, arm: str) -> ResultRecord:
    """Return a result as if it were that of an arm, each of its checkpoints taken where its curve is best."""
    settings = target_method(METHODS[source.agent], get_task(source.task), BUDGET).config_hash
    runs = []
    for run in source.runs:
        assert run.training is not None
        begun = {"arm": arm, "command": None, "source_sha256": None if arm == "scratch" else run.checkpoint_sha256}
        steps = {"env_steps": 0, "budget": None} if arm == "zero-shot" else {"env_steps": BUDGET, "budget": BUDGET}
        training = run.training.model_copy(update={**begun, **steps, "config_hash": settings})
        other = sha256_of(f"{arm} {run.checkpoint_sha256}".encode())
        runs.append(run.model_copy(update={"training": training, "checkpoint_sha256": other}))
    return source.model_copy(update={"agent": f"{source.agent} {arm}", "runs": tuple(runs)})


def _transfer(source: ResultRecord) -> TransferSetRecord:
    steps, count = (0, BUDGET // 2, BUDGET), len(source.seeds)
    arms: dict[ArmName, ArmCurves] = {
        "scratch": ArmCurves(source.seeds, steps, ((0.0, 0.25, 0.953125), *[(0.0, 0.25, 0.5)] * (count - 1))),
        "fine-tune": ArmCurves(source.seeds, steps, ((0.5, 0.953125, 1.0), *[(0.25, 0.75, 0.9375)] * (count - 1))),
        "zero-shot": ArmCurves(source.seeds, (0,), ((0.5,), *[(0.25,)] * (count - 1))),
    }
    return transfer_set([TransferCurves(source.task, source.task, source.agent, arms)])


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
