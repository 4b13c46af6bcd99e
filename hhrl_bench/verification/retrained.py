"""Training seeds of an entry trained again, from what their checkpoints say, to the same files and learning curves."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from hhrl_agents.policies.checkpoint_file import read_metadata
from hhrl_bench.evaluation.loading import training_record
from hhrl_bench.evaluation.records import RunRecord, TrainingRecord
from hhrl_bench.evaluation.results import Update, silent
from hhrl_bench.evaluation.store import Store
from hhrl_bench.execution.pools import Each
from hhrl_bench.leaderboard.findings import Finding, differences
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.schema import sha256_of
from hhrl_bench.tasks.tasks import registered_task
from hhrl_bench.training.reuse import Source, load_source
from hhrl_bench.training.run_directory import RunDirectory
from hhrl_bench.training.train import Plan, get_method, train
from hhrl_bench.transfer.transfer import Transfer
from hhrl_bench.verification.checked_result import CheckedResult, checked_results
from hhrl_bench.verification.curves import check_trained
from hhrl_bench.verification.identity import repeatable, shipped
from hhrl_bench.verification.rerun import decides_otherwise
from hhrl_envs import get_scenario
from hhrl_envs.errors import InputError


class Trained(NamedTuple):
    """A seed of an entry: its training, and the run that came of it, at a place; None: the training failed."""

    place: str
    training: TrainingRecord
    result: int
    run: RunRecord | None

    @property
    def sha256(self) -> str | None:
        """The sha256 of its checkpoint."""
        return self.run.checkpoint_sha256 if self.run else None


def trained_seeds(board: LeaderboardRecord) -> list[Trained]:
    """Return the trained seeds of an entry, failed ones too.

    Of those with published checkpoints each is there once, whatever results it has, as rerun shows their decisions.
    """
    found: dict[object, Trained] = {}
    for index, result in enumerate(board.results):
        for number, run in enumerate(result.runs):
            if run.checkpoint_sha256 and run.training:
                key = run.checkpoint_sha256, None if board.checkpoints_published else index
                place = f"results[{index}].runs[{number}]"
                found.setdefault(key, Trained(place, run.training, index, run))
        if shared := result.runs[0].training:
            for seed in result.failed_seeds:
                training = shared.model_copy(update={"seed": seed})
                found[index, seed] = Trained(f"results[{index}].failed_seeds", training, index, None)
    return list(found.values())


def retrain(
    board: LeaderboardRecord,
    store: Store,
    update: Update = silent,
    sample: int | None = None,
    seed: int = 0,
    each: Each = map,
) -> Iterator[Finding]:
    """Train the seeds of an entry again whose training is exact, and return what comes out otherwise.

    That is: the checkpoint, the learning curve, that a training fails, and, of checkpoints that are not published, what
    they decide. Of the seeds, ``sample`` are trained, drawn by ``seed``; or all. ``each`` trains them, as ``map`` does.
    ``update`` hears how many steps of one are done, or how many seeds where they are trained in other processes.
    """
    every = [one for one in trained_seeds(board) if repeatable(one.training)]
    count = len(every) if sample is None else min(sample, len(every))
    chosen = [every[index] for index in np.sort(np.random.default_rng(seed).permutation(len(every))[:count])]
    checked = checked_results(board, store)
    results, here = [checked[one.result] for one in chosen], each is map
    for done, findings in enumerate(each(partial(train_again, board, update if here else silent), chosen, results)):
        if not here:
            training = chosen[done].training
            update(done + 1, count, f"trained {training.method} on {training.task}, seed {training.seed}")
        yield from findings


def train_again(board: LeaderboardRecord, update: Update, one: Trained, checked: CheckedResult) -> list[Finding]:
    """Return what does not hold of a seed of an entry that is trained again; ``checked`` is the result it is of."""
    with TemporaryDirectory() as folder:
        try:
            return list(_Retraining(board, Path(folder), update).check(one, checked))
        except InputError as error:
            return [Finding(one.place, f"cannot be trained again: {error}")]


class _Retraining:
    """Trainings of seeds of an entry, with their run directories in a folder."""

    def __init__(self, board: LeaderboardRecord, folder: Path, update: Update) -> None:
        self._board, self._folder, self._update = board, folder, update
        trained = [one.training for one in trained_seeds(board)]
        self._trainings = {one.sha256: one.training for one in trained_seeds(board) if one.sha256}
        self._budgets = {(one.method, one.task): one.budget for one in trained if one.arm and one.budget}

    def check(self, one: Trained, checked: CheckedResult) -> Iterator[Finding]:
        """Train a seed again, and return what comes out otherwise."""
        seed, path = one.training.seed, self._train(one.training)
        if one.run is None and path.exists():
            yield Finding(one.place, f"trained again, seed {seed} does not fail")
            return
        if one.run is not None and (found := sha256_of(_required(path).read_bytes())) != one.sha256:
            yield Finding(f"{one.place}.checkpoint_sha256", f"trained again, seed {seed} leaves {found}")
            return
        if one.run is not None and not checked.checkpoints:
            store = Store(self._folder)
            store.add_checkpoint(path.read_bytes())
            trace = checked.read(one.run).trace
            yield from decides_otherwise(one.place, replace(checked, store=store), one.run, trace)
        if one.run is not None:
            again = training_record(read_metadata(path), path)
            yield from differences(f"{one.place}.training", one.training.model_dump(), again.model_dump())
        yield from check_trained(self._board, one.training, path.parent)

    def _train(self, training: TrainingRecord) -> Path:
        """Train a seed again, and return where its chosen checkpoint is, if the training has not failed."""
        plan = self._plan(training)
        if plan.method.config_hash != training.config_hash:
            raise InputError(f"this version's {training.method} has other settings")
        for report in train(plan):
            note = f"train {training.method} on {training.task}, seed {training.seed}: {report.note}"
            self._update(report.env_steps, max(plan.env_steps, 1), note)
        return RunDirectory(plan.folder).best(training.seed)

    def _plan(self, training: TrainingRecord) -> Plan:
        method, task, budget = get_method(training.method), registered_task(training.task or ""), training.budget or 0
        if training.arm is None:
            return Plan(method, task, (training.seed,), budget, self._folder / "run")
        source, known = self._source(training), self._budgets.get((training.method, training.task))
        return Transfer(source.name, task, (training.seed,), known or budget, self._folder).plan(training.arm, source)

    def _source(self, training: TrainingRecord) -> Source:
        """Return what an arm began with, trained again too."""
        sha256, scenario = training.source_sha256, get_scenario(training.scenario)
        if sha256 is None:
            return Source("nothing", get_method(training.method), scenario.id, {}, {})
        if sha256 in shipped(training.method):
            return load_source(training.method, scenario)
        source = self._trainings.get(sha256)
        if source is None or source.arm:
            raise InputError(f"its source {sha256} is not among the results")
        return load_source(str(_required(self._train(source)).parent), scenario)


def _required(path: Path) -> Path:
    if not path.exists():
        raise InputError("its training failed")
    return path
