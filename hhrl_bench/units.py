"""Units: the smallest pieces of a suite's work, each of which any process can do and whose outcome is one result.

A unit that trains keeps everything in a run directory of its own, so that a stopped one goes on; its outcome is a file
there, so that a finished one is not done again.
"""

import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from pydantic import ValidationError

from hhrl_agents.files import write_atomically
from hhrl_bench.loading import load_agents
from hhrl_bench.records import TimedResult
from hhrl_bench.results import evaluate_agent
from hhrl_bench.run_directory import RunDirectory
from hhrl_bench.tasks import Task
from hhrl_envs import get_scenario
from hhrl_envs.extras import require

if TYPE_CHECKING:
    from hhrl_bench.train import Plan
    from hhrl_bench.transfer import Transfer

OUTCOME = "result-{}.json"
"""Name of the outcome's file in a run directory, by the number of test episodes."""


class Unit(Protocol):
    """A piece of work; all that it needs is in its fields, and what it does depends on nothing else."""

    @property
    def name(self) -> str:
        """What it is called in messages."""

    def check(self) -> None:
        """Return nothing; raises an InputError where it is plain from the outset that ``run`` cannot succeed."""

    def run(self) -> TimedResult:
        """Return the outcome, and the seconds it took."""


@dataclass(frozen=True, slots=True)
class Evaluation:
    """One agent on one task, with all its training seeds."""

    agent: str
    task: Task
    episodes: int

    @property
    def name(self) -> str:
        """The agent and the task."""
        return f"{self.agent} on {self.task.id}"

    def check(self) -> None:
        """Return nothing; see ``Unit.check``: the agent has to load."""
        load_agents(self.agent, get_scenario(self.task.scenario))

    def run(self) -> TimedResult:
        """Return the result on the task's first test episodes."""
        started = time.perf_counter()
        result = evaluate_agent(self.agent, self.task, self.episodes)
        return TimedResult(result=result, seconds=time.perf_counter() - started)


@dataclass(frozen=True, slots=True)
class Training:
    """One method trained on one task from nothing, its chosen checkpoints evaluated there."""

    method: str
    task: Task
    seeds: tuple[int, ...]
    episodes: int
    folder: Path

    @property
    def name(self) -> str:
        """The method and the task."""
        return f"{self.method} on {self.task.id}"

    def check(self) -> None:
        """Return nothing; see ``Unit.check``: the method has to be known, and torch be there."""
        require("torch", "torch")
        from hhrl_bench.train import get_method  # noqa: PLC0415

        get_method(self.method)

    def run(self) -> TimedResult:
        """Return the result of the chosen checkpoints under the method's name, trained first where they are not yet."""
        from hhrl_bench.train import Plan, get_method  # noqa: PLC0415

        started = time.perf_counter()
        plan = Plan(get_method(self.method), self.task, self.seeds, self.task.env_steps, self.folder)
        return _trained(plan, self.method, self.episodes, started)


@dataclass(frozen=True, slots=True)
class TransferArm:
    """One arm of a transfer, its chosen checkpoints evaluated in the target; see :class:`hhrl_bench.arms.Arm`."""

    transfer: "Transfer"
    method: str
    arm: str
    episodes: int

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

    def run(self) -> TimedResult:
        """Return the result of the chosen checkpoints, trained first where they are not yet."""
        started = time.perf_counter()
        plan = self.transfer.plan(self.arm, self.transfer.load())
        return _trained(plan, self.agent, self.episodes, started)


def _trained(plan: "Plan", name: str, episodes: int, started: float) -> TimedResult:
    """Return the result of a training under a name; what was trained and scored before is read."""
    from hhrl_bench.train import train  # noqa: PLC0415

    for _ in train(plan, resume=True):
        pass
    path = plan.folder / OUTCOME.format(episodes)
    known = _read(path)
    if known and known.result.agent == name:
        return known
    result = evaluate_agent(str(plan.folder), plan.task, episodes).model_copy(update={"agent": name})
    timed = TimedResult(result=result, seconds=time.perf_counter() - started)
    write_atomically(path, timed.model_dump_json(indent=2) + "\n")
    return timed


def _read(path: Path) -> TimedResult | None:
    try:
        return TimedResult.model_validate_json(path.read_bytes())
    except (OSError, ValidationError):
        return None
