"""Units: the smallest pieces of a suite's work, each of which any process can do and whose outcome is one result.

A unit that trains keeps everything in a run directory of its own, so that a stopped one goes on; the outcome of every
unit is a file, so that a finished one is not done again.
"""

import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from hhrl_bench.evaluation.loading import load_agents
from hhrl_bench.evaluation.records import TimedResult
from hhrl_bench.evaluation.results import evaluate_agent
from hhrl_bench.evaluation.store import Store
from hhrl_bench.progress import Update, silent
from hhrl_bench.suites.outcome_file import keep_outcome
from hhrl_bench.tasks.tasks import Task
from hhrl_bench.text import file_name
from hhrl_bench.training.run_directory import RunDirectory, failed_seeds
from hhrl_envs import get_scenario
from hhrl_envs.errors import require

if TYPE_CHECKING:
    from hhrl_bench.training.train import Plan
    from hhrl_bench.transfer.transfer import Transfer

OUTCOME = "result-{}.json"
"""Name of the outcome's file in a run directory, by the number of test episodes."""


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
        """Return nothing; see ``Unit.check``: the agent has to load."""
        load_agents(self.agent, get_scenario(self.task.scenario))

    def run(self, update: Update = silent) -> TimedResult:
        """Return the result on the task's first test episodes."""
        path = self.folder / file_name(self.agent) / self.task.id / OUTCOME.format(self.episodes)
        return keep_outcome(path, lambda: self._score(update), self.agent, self.task, Store(self.folder))

    def _score(self, update: Update) -> TimedResult:
        started = time.perf_counter()
        result = evaluate_agent(self.agent, self.task, self.episodes, update=update, store=Store(self.folder))
        return TimedResult(result=result, seconds=time.perf_counter() - started)


@dataclass(frozen=True, slots=True)
class Training:
    """One method trained on one task from nothing, its chosen checkpoints evaluated there.

    ``folder`` is its run directory; its evidence lies in ``store``.
    """

    method: str
    task: Task
    seeds: tuple[int, ...]
    episodes: int
    folder: Path
    store: Store

    @property
    def name(self) -> str:
        """The method and the task."""
        return f"{self.method} on {self.task.id}"

    def check(self) -> None:
        """Return nothing; see ``Unit.check``: the method has to be known, and torch be there."""
        require("torch", "torch")
        from hhrl_bench.training.train import get_method  # noqa: PLC0415

        get_method(self.method)

    def run(self, update: Update = silent) -> TimedResult:
        """Return the result of the chosen checkpoints under the method's name, trained first where they are not yet."""
        from hhrl_bench.training.train import Plan, get_method  # noqa: PLC0415

        plan = Plan(get_method(self.method), self.task, self.seeds, self.task.env_steps, self.folder)
        return _trained(plan, self.method, self.episodes, self.store, update)


@dataclass(frozen=True, slots=True)
class TransferArm:
    """One arm of a transfer, its chosen checkpoints evaluated in the target; see ``Arm``."""

    transfer: "Transfer"
    method: str
    arm: str
    episodes: int
    store: Store

    @property
    def name(self) -> str:
        """The method, the arm and the target."""
        return f"{self.agent} on {self.transfer.target.id}"

    @property
    def agent(self) -> str:
        """What the result is called: the method in this arm."""
        return f"{self.method} {self.arm}"

    def check(self) -> None:
        """Return nothing; see ``Unit.check``; what was begun has to be of this source, which may have to be trained."""
        require("torch", "torch")
        folder = self.transfer.folder_of(self.arm)
        if folder.exists():
            RunDirectory(folder).require_config(self.transfer.plan(self.arm, self.transfer.load()).config())

    def run(self, update: Update = silent) -> TimedResult:
        """Return the result of the chosen checkpoints, trained first where they are not yet."""
        plan = self.transfer.plan(self.arm, self.transfer.load())
        return _trained(plan, self.agent, self.episodes, self.store, update)


def _trained(plan: "Plan", name: str, episodes: int, store: Store, update: Update) -> TimedResult:
    """Return the result of a training under a name; what was trained and scored before is read."""
    from hhrl_bench.training.train import train  # noqa: PLC0415

    for report in train(plan, resume=True):
        update(report.env_steps, plan.env_steps, report.note)
    source = str(plan.folder)

    def score() -> TimedResult:
        started = time.perf_counter()
        result = evaluate_agent(source, plan.task, episodes, store=store)
        failed = tuple(seed for seed in failed_seeds(plan.folder) if seed in plan.seeds)
        result = result.model_copy(update={"agent": name, "failed_seeds": failed})
        seconds = RunDirectory(plan.folder).seconds(plan.seeds) + time.perf_counter() - started
        return TimedResult(result=result, seconds=seconds)

    return keep_outcome(plan.folder / OUTCOME.format(episodes), score, source, plan.task, store)
