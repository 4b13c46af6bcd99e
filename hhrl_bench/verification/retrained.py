"""Training seeds of an entry trained again, from what their checkpoints say, to the same files."""

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from hhrl_bench.evaluation.records import TrainingRecord
from hhrl_bench.evaluation.results import Update, silent
from hhrl_bench.leaderboard.findings import Finding
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.schema import sha256_of
from hhrl_bench.tasks.tasks import registered_task
from hhrl_bench.training.reuse import Source, load_source
from hhrl_bench.training.run_directory import RunDirectory
from hhrl_bench.training.train import Plan, get_method, train
from hhrl_bench.transfer.transfer import Transfer
from hhrl_envs import get_scenario
from hhrl_envs.errors import InputError


class Trained(NamedTuple):
    """A checkpoint of an entry: the place that names it first, its sha256, and its training."""

    place: str
    sha256: str
    training: TrainingRecord


def trained_seeds(board: LeaderboardRecord) -> list[Trained]:
    """Return the checkpoints of an entry, each once, but for policies that are reused without any training."""
    found: dict[str, Trained] = {}
    for index, result in enumerate(board.results):
        for number, run in enumerate(result.runs):
            if run.checkpoint_sha256 and run.training and run.training.budget:
                own = Trained(f"results[{index}].runs[{number}]", run.checkpoint_sha256, run.training)
                found.setdefault(own.sha256, own)
    return list(found.values())


def retrain(
    board: LeaderboardRecord, update: Update = silent, sample: int | None = None, seed: int = 0
) -> Iterator[Finding]:
    """Train the seeds of an entry again whose training is exact, and return the checkpoints that come out otherwise.

    Of the seeds, ``sample`` are trained, drawn by ``seed``; or all. ``update`` hears how many steps of one are done.
    """
    every = [one for one in trained_seeds(board) if one.training.exact]
    count = len(every) if sample is None else min(sample, len(every))
    for index in np.sort(np.random.default_rng(seed).permutation(len(every))[:count]):
        one = every[index]
        with TemporaryDirectory() as folder:
            try:
                path = _Retraining(board, Path(folder), update).checkpoint(one.training)
            except InputError as error:
                yield Finding(one.place, f"cannot be trained again: {error}")
                continue
            found = sha256_of(path.read_bytes())
        if found != one.sha256:
            yield Finding(f"{one.place}.checkpoint_sha256", f"trained again, seed {one.training.seed} leaves {found}")


class _Retraining:
    """Trainings of seeds of an entry, with their run directories in a folder."""

    def __init__(self, board: LeaderboardRecord, folder: Path, update: Update) -> None:
        self._folder, self._update = folder, update
        self._trainings = {one.sha256: one.training for one in trained_seeds(board)}

    def checkpoint(self, training: TrainingRecord) -> Path:
        """Return the chosen checkpoint of a training that was done again."""
        plan = self._plan(training)
        if plan.method.config_hash != training.config_hash:
            raise InputError(f"this version's {training.method} has other settings")
        for report in train(plan):
            note = f"train {training.method} on {training.task}, seed {training.seed}: {report.note}"
            self._update(report.env_steps, plan.env_steps, note)
        path = RunDirectory(plan.folder).best(training.seed)
        if not path.exists():
            raise InputError("its training failed")
        return path

    def _plan(self, training: TrainingRecord) -> Plan:
        method, task, budget = get_method(training.method), registered_task(training.task or ""), training.budget or 0
        if training.arm is None:
            return Plan(method, task, (training.seed,), budget, self._folder / "run")
        source = self._source(training)
        return Transfer(source.name, task, (training.seed,), budget, self._folder).plan(training.arm, source)

    def _source(self, training: TrainingRecord) -> Source:
        """Return what an arm began with, trained again too."""
        sha256, scenario = training.source_sha256, get_scenario(training.scenario)
        if sha256 is None:
            return Source("nothing", get_method(training.method), scenario.id, {}, {})
        source = self._trainings.get(sha256)
        if source is None or source.arm:
            raise InputError(f"its source {sha256} is not among the results")
        return load_source(str(self.checkpoint(source).parent), scenario)
