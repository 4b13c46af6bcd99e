"""Training: a learner's reports, each seed's policy validated at every report, the best one kept."""

import math
import shlex
import time
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hhrl_agents import METHODS, checkpoints
from hhrl_agents.files import write_atomically
from hhrl_agents.learned import LearnedAgent
from hhrl_agents.learners import Progress
from hhrl_agents.training import make_learner
from hhrl_bench.errors import AgentError
from hhrl_bench.evaluation import play
from hhrl_bench.metrics import finite, means
from hhrl_bench.provenance import provenance
from hhrl_bench.run_directory import RunDirectory
from hhrl_bench.seeds import UInt64Array, format_seeds
from hhrl_bench.tasks import Task
from hhrl_bench.threads import one_torch_thread
from hhrl_envs import Outcome, get_scenario

VALIDATION_EPISODES = 256


@dataclass(frozen=True)
class Plan:
    """What to train, for how many environment steps a seed, and the run directory to fill."""

    method: str
    task: Task
    seeds: tuple[int, ...]
    env_steps: int
    folder: Path

    def __post_init__(self) -> None:
        """Reject a method that is not registered."""
        if self.method not in METHODS:
            raise AgentError(f"unknown method {self.method!r}; write one of: {', '.join(METHODS)}")

    @property
    def command(self) -> str:
        """The command that trains the same again."""
        words = ["hhrl-bench", "train", self.method, "--task", self.task.id, "--seeds", format_seeds(self.seeds)]
        budget = [] if self.env_steps == self.task.env_steps else ["--env-steps", str(self.env_steps)]
        return shlex.join([*words, *budget])

    def config(self) -> dict[str, Any]:
        """Return what all seeds of the run share, as JSON data."""
        method, scenario = METHODS[self.method], get_scenario(self.task.scenario)
        return {
            "method": asdict(method),
            "config_hash": method.config_hash,
            "task": self.task.id,
            "scenario": scenario.id,
            "spec_hash": scenario.spec_hash,
            "env_steps": self.env_steps,
            "validation_episodes": VALIDATION_EPISODES,
        }


class Report(NamedTuple):
    """How far a training is: env steps done, and each seed's validation success rate."""

    env_steps: int
    success: tuple[float, ...]


@dataclass
class SeedRun:
    """One seed of a training: its learning curve, and its best policy so far."""

    seed: int
    curve: list[dict[str, Any]] = field(default_factory=list)
    score: tuple[float, ...] = (-math.inf,)
    best: LearnedAgent | None = None
    best_row: Mapping[str, Any] = field(default_factory=dict)


def train(plan: Plan) -> Iterator[Report]:
    """Return, one after the other, the reports of a training; at its end the run directory holds the checkpoints.

    Raises:
        OutputError: before training begins, if the run directory cannot be written or holds other runs.
    """
    started = time.perf_counter()
    directory = RunDirectory(plan.folder)
    directory.prepare(plan.config(), plan.seeds)
    runs = [SeedRun(seed) for seed in plan.seeds]
    scenario, method = get_scenario(plan.task.scenario), METHODS[plan.method]
    with one_torch_thread():
        learner = make_learner(method, scenario, plan.seeds, _world_seeds(plan, method.config.n_envs))
        for progress in learner.train(plan.env_steps):
            yield _report(plan, directory, runs, progress, learner.policies())
        _save(plan, directory, runs, learner.policies())
    elapsed = time.perf_counter() - started
    record = provenance(plan.command, {f"{plan.task.id}/{plan.method}": elapsed})
    path = directory.folder / f"provenance-seeds-{format_seeds(plan.seeds)}.json"
    write_atomically(path, record.model_dump_json(indent=2) + "\n")


def _world_seeds(plan: Plan, n_envs: int) -> UInt64Array:
    """Return the training worlds [E, n_envs]: seed k has block k of the train range, whatever it is stacked with."""
    return np.stack([plan.task.train.take(n_envs, offset=seed * n_envs) for seed in plan.seeds])


def _report(
    plan: Plan, directory: RunDirectory, runs: list[SeedRun], progress: Progress, policies: list[LearnedAgent]
) -> Report:
    scenario, seeds = get_scenario(plan.task.scenario), plan.task.validation.take(VALIDATION_EPISODES)
    for index, (run, policy) in enumerate(zip(runs, policies, strict=True)):
        counts = progress.outcome_counts[index]
        row = {
            "env_steps": progress.env_steps,
            "updates": progress.updates,
            "losses": finite({level: float(losses[index]) for level, losses in progress.losses.items()}),
            "episodes": {outcome.name.lower(): int(counts[outcome]) for outcome in Outcome if counts[outcome]},
            "validation": finite(means(play(policy, scenario, seeds, rows=VALIDATION_EPISODES))),
        }
        _keep(run, row, policy)
        directory.write_curve(run.seed, run.curve)
    return Report(progress.env_steps, tuple(run.curve[-1]["validation"]["success"] for run in runs))


def _keep(run: SeedRun, row: dict[str, Any], policy: LearnedAgent) -> None:
    """Add a report to a seed's curve; its policy is the best on more successes, then fewer collisions, then reward."""
    run.curve.append(row)
    validation = row["validation"]
    score = (validation["success"], -validation["collision"], validation["return_task"])
    if score > run.score:
        run.score, run.best, run.best_row = score, policy, row


def _save(plan: Plan, directory: RunDirectory, runs: list[SeedRun], last: list[LearnedAgent]) -> None:
    for run, policy in zip(runs, last, strict=True):
        best = run.best or policy
        for path, agent, row in (
            (directory.best(run.seed), best, run.best_row),
            (directory.final(run.seed), policy, run.curve[-1]),
        ):
            metadata = {"command": plan.command, "budget": plan.env_steps, "validation": row["validation"]}
            checkpoints.save(path, agent, metadata)
