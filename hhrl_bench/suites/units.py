"""Units: the smallest pieces of a suite's work, each of which any process can do.

A unit trains one seed, in the run directory of its training, so that a stopped one goes on; or its outcome is one
result, kept in a file, so that a finished one is not done again while nothing about it has changed.
"""

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import ValidationError

from hhrl_agents.atomic_files import write_atomically
from hhrl_agents.methods.method import Method
from hhrl_bench.errors import RecordError
from hhrl_bench.evaluation.loading import load_agents, require_loadable
from hhrl_bench.evaluation.records import ResultRecord, RunRecord, TimedResult, TrainedSeed
from hhrl_bench.evaluation.results import Update, evaluate_agent, silent
from hhrl_bench.evaluation.store import Store, read
from hhrl_bench.provenance import code_sha256
from hhrl_bench.schema import Record, Sha256
from hhrl_bench.tasks.tasks import Task
from hhrl_bench.text import file_name
from hhrl_bench.training.run_directory import RunDirectory, failed_seeds
from hhrl_bench.transfer.transfer import Transfer, sensible_arms
from hhrl_envs import get_scenario
from hhrl_envs.errors import require

if TYPE_CHECKING:
    from hhrl_bench.training.train import Plan

OUTCOME_FILE = "result-{}.json"
"""Name of the outcome's file in a run directory, by the number of test episodes."""

LOST_PATIENCE = 120.0
"""Seconds for which a file server may keep the lock of a node that was lost while it trained."""


@dataclass(frozen=True, slots=True)
class Evaluation:
    """One agent on one task, with all its training seeds; its outcome and evidence lie in ``folder``."""

    agent: str
    task: Task
    episodes: int
    folder: Path

    @property
    def name(self) -> str:
        """The agent and the task."""
        return f"{self.agent} on {self.task.id}"

    def check(self) -> None:
        """Raise an ``InputError`` if the agent does not load."""
        require_loadable(self.agent, self.task)

    def run(self, update: Update = silent) -> TimedResult:
        """Return the result on the task's first test episodes."""
        path = self.folder / file_name(self.agent) / self.task.id / OUTCOME_FILE.format(self.episodes)
        return keep_outcome(path, lambda: self._score(update), self.agent, self.task, Store(self.folder))

    def _score(self, update: Update) -> TimedResult:
        started = time.perf_counter()
        result = evaluate_agent(self.agent, self.task, self.episodes, update=update, store=Store(self.folder))
        return TimedResult(result=result, seconds=time.perf_counter() - started)


@dataclass(frozen=True, slots=True)
class Training:
    """One method trained on one task; what it comes to is its chosen checkpoints, evaluated there.

    Its seeds have been trained before, by the units of ``seed_trainings``.

    Attributes:
        method: id of the method.
        task: what it is trained and evaluated on.
        seeds: training seeds.
        episodes: test episodes of the evaluation.
        folder: the run directory.
        store: where the evidence lies.
        transfer: what the training is an ``arm`` of; None: it begins from nothing and has the task's budget.
        arm: id of the arm.
    """

    method: str
    task: Task
    seeds: tuple[int, ...]
    episodes: int
    folder: Path
    store: Store
    transfer: Transfer | None = None
    arm: str = ""

    @property
    def agent(self) -> str:
        """What the result is called: the method, and its arm if it has one."""
        return f"{self.method} {self.arm}".rstrip()

    @property
    def name(self) -> str:
        """The method, the arm and the task."""
        return f"{self.agent} on {self.task.id}"

    def plan(self) -> "Plan":
        """Return the training of all seeds; an arm's source is trained by now."""
        from hhrl_bench.training.train import Plan, get_method  # noqa: PLC0415

        if self.transfer is not None:
            return self.transfer.plan(self.arm, self.transfer.load())
        return Plan(get_method(self.method), self.task, self.seeds, self.task.env_steps, self.folder)

    def check(self) -> None:
        """Raise an ``InputError`` if the method or its library is missing, or an arm was begun with another source.

        The source of an arm that was not begun may still have to be trained.
        """
        from hhrl_bench.training.train import get_method  # noqa: PLC0415

        if self.transfer is None:
            extra = get_method(self.method).config.extra
            if extra is not None:
                require(*extra)
        elif self.folder.exists():
            RunDirectory(self.folder).require_config(self.plan().config())

    def run(self, update: Update = silent) -> TimedResult:
        """Return the result of the chosen checkpoints."""
        path = self.folder / OUTCOME_FILE.format(self.episodes)
        return keep_outcome(path, self._score, self.agent, self.task, self.store, source=str(self.folder))

    def _score(self) -> TimedResult:
        started = time.perf_counter()
        result = evaluate_agent(str(self.folder), self.task, self.episodes, store=self.store)
        failed = tuple(seed for seed in failed_seeds(self.folder) if seed in self.seeds)
        result = result.model_copy(update={"agent": self.agent, "failed_seeds": failed})
        trained = sum(map(RunDirectory(self.folder).seconds, self.seeds))
        return TimedResult(result=result, seconds=trained + time.perf_counter() - started)


@dataclass(frozen=True, slots=True)
class SeedTraining:
    """One seed of a training, which depends on no other one."""

    training: Training
    seed: int

    @property
    def name(self) -> str:
        """The training and the seed."""
        return f"{self.training.name}, seed {self.seed}"

    def check(self) -> None:
        """Do nothing: the training, which comes later, is checked for all its seeds."""

    def run(self, update: Update = silent) -> TrainedSeed:
        """Train the seed, unless that is done; its checkpoints lie in the run directory."""
        from hhrl_bench.training.train import train  # noqa: PLC0415

        plan, note = replace(self.training.plan(), seeds=(self.seed,)), "trained before"
        for report in train(plan, resume=True, patience=LOST_PATIENCE):
            note = report.note
            update(report.env_steps, plan.env_steps, note)
        return TrainedSeed(RunDirectory(plan.folder).seconds(self.seed), note)


def seed_trainings(trainings: Iterable[Training]) -> list[SeedTraining]:
    """Return the units that train every seed of these trainings."""
    return [SeedTraining(training, seed) for training in trainings for seed in training.seeds]


def arm_trainings(transfer: Transfer, method: Method, episodes: int, store: Store) -> list[Training]:
    """Return the training of every arm that makes sense for a method in a transfer's target."""
    return [
        Training(
            method.id, transfer.target, transfer.seeds, episodes, transfer.folder_of(arm.id), store, transfer, arm.id
        )
        for arm in sensible_arms(method, transfer.target)
    ]


class OutcomeRecord(Record):
    """An outcome, and the hashes of the code that made it and of the scenario in which it was made."""

    code_sha256: Sha256
    spec_hash: Sha256
    outcome: TimedResult


def keep_outcome(
    path: Path, make: Callable[[], TimedResult], agent: str, task: Task, store: Store, source: str | None = None
) -> TimedResult:
    """Return the outcome in a file, or the one that ``make`` makes anew, which is then written there.

    It is made anew where there is none, where it was made by other code or in a scenario that has changed, where
    ``agent`` has other checkpoints now, and where the store lacks some of its files or holds damaged ones. An agent
    that is the user's own code is always scored anew. The checkpoints are those of ``source``, if the agent is another
    one's name.
    """
    made_by = {"code_sha256": code_sha256(), "spec_hash": get_scenario(task.scenario).spec_hash}
    known = _read(path)
    is_same = known is not None and known.model_dump(include=set(made_by)) == made_by
    if known and is_same and _still_holds(known.outcome.result, agent, source or agent, task, store):
        return known.outcome
    outcome = make()
    record = OutcomeRecord(**made_by, outcome=outcome)
    write_atomically(path, record.model_dump_json(indent=2) + "\n")
    return outcome


def _read(path: Path) -> OutcomeRecord | None:
    try:
        return OutcomeRecord.model_validate_json(path.read_bytes())
    except (OSError, ValidationError):
        return None


def _still_holds(result: ResultRecord, agent: str, source: str, task: Task, store: Store) -> bool:
    if result.kind == "factory" or (result.agent, result.task, result.option) != (agent, task.id, None):
        return False
    loaded = load_agents(source, get_scenario(task.scenario))
    return (
        all(one.kind == result.kind for one in loaded)
        and [one.sha256 for one in loaded] == [run.checkpoint_sha256 for run in result.runs]
        and all(_are_whole(run, store) for run in result.runs)
    )


def _are_whole(run: RunRecord, store: Store) -> bool:
    """Return whether the evidence and the checkpoint of a run, if it has one, lie in the store, and are not damaged."""
    try:
        read(store.evidence(str(run.evidence_sha256)))
        if run.checkpoint_sha256:
            read(store.checkpoint(run.checkpoint_sha256))
    except RecordError:
        return False
    return True
