"""Training: the learners' reports, each seed's policy validated at every report, the best one kept."""

import shlex
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from math import isfinite, isnan, nan
from pathlib import Path
from typing import Any, NamedTuple

import numba
import numpy as np

from hhrl_agents import METHODS
from hhrl_agents.atomic_files import write_atomically
from hhrl_agents.methods.method import Method
from hhrl_agents.policies import checkpoints
from hhrl_agents.policies.learned_agent import LearnedAgent, make_agent
from hhrl_agents.stateful import below, prefixed
from hhrl_agents.training.learner import NOTHING, Learner, Progress, make_learner
from hhrl_bench.errors import AgentError
from hhrl_bench.evaluation.metrics import means, watched
from hhrl_bench.evaluation.paired_evaluation import play, training_drivers
from hhrl_bench.provenance import provenance
from hhrl_bench.schema import finite
from hhrl_bench.tasks.seeds import format_seeds
from hhrl_bench.tasks.tasks import Task
from hhrl_bench.text import meant
from hhrl_bench.training.extension import extend, extends
from hhrl_bench.training.reuse import Reuse
from hhrl_bench.training.run_directory import RunDirectory
from hhrl_bench.training.saved_state import ReportRow, SeedRun, StateFile, TrainingState
from hhrl_bench.training.trackers import TRACKERS, Tracker, require_trackers
from hhrl_envs import Outcome, get_scenario
from hhrl_envs.arrays import Keys
from hhrl_envs.errors import require, require_value

VALIDATION_EPISODES = 256
PATIENCE = 1.0
"""Seconds that a training waits for another one of the same seeds to let go of the run directory."""

ENGINES = ("compiled", "torch")


@dataclass(frozen=True)
class Plan:
    """What to train.

    Attributes:
        method: the method.
        task: what it is trained on.
        seeds: training seeds.
        env_steps: budget of a seed, in environment steps.
        folder: the run directory to fill.
        reuse: what the seeds begin with; None: they begin from nothing.
        engine: "compiled", exact on every processor, or "torch", the reference, which reads like the paper.
        device: where torch computes, "cpu" or "cuda"; the compiled engine uses the CPU.
        schedule_steps: over how many steps exploration and learning rate change; None: the budget.
    """

    method: Method
    task: Task
    seeds: tuple[int, ...]
    env_steps: int
    folder: Path
    reuse: Reuse | None = None
    engine: str = "compiled"
    device: str = "cpu"
    schedule_steps: int | None = None

    def __post_init__(self) -> None:
        """Refuse an engine that there is not, and a device that the engine does not use."""
        require_value(self.engine in ENGINES, "engine", repr(self.engine), " or ".join(ENGINES))
        fits = self.engine == "torch" or self.device == "cpu"
        require_value(fits, "device", repr(self.device), "cpu, or the engine torch too")

    @property
    def span(self) -> int:
        """Over how many steps exploration and learning rate change."""
        return self.schedule_steps or self.env_steps

    @property
    def command(self) -> str:
        """The command that trains the same again."""
        return self.reuse.command if self.reuse else self._train(self.seeds)

    def origin(self, seed: int) -> dict[str, Any]:
        """Return what the checkpoints of a seed say of their training; it is the same whatever trains beside it."""
        begins = self.reuse.origin(seed) if self.reuse else {"command": self._train((seed,))}
        return {"task": self.task.id, "budget": self.env_steps or None, **begins}

    def _train(self, seeds: Sequence[int]) -> str:
        words = ["hhrl-bench", "train", self.method.id, "--task", self.task.id, "--seeds", format_seeds(seeds)]
        budget = [] if self.env_steps == self.task.env_steps else ["--env-steps", str(self.env_steps)]
        schedule = [] if self.span == self.env_steps else ["--schedule-steps", str(self.span)]
        engine = [] if self.engine == "compiled" else ["--engine", self.engine, "--device", self.device]
        return shlex.join([*words, *budget, *schedule, *engine])

    def config(self) -> dict[str, Any]:
        """Return what all seeds of the run share, as JSON data."""
        scenario = get_scenario(self.task.scenario)
        return {
            "method": asdict(self.method),
            "config_hash": self.method.config_hash,
            "task": self.task.id,
            "scenario": scenario.id,
            "spec_hash": scenario.spec_hash,
            "env_steps": self.env_steps,
            **({} if self.span == self.env_steps else {"schedule_steps": self.span}),
            "validation_episodes": VALIDATION_EPISODES,
            **({} if self.engine == "compiled" else {"engine": self.engine, "device": self.device}),
            **({"transfer": self.reuse.config()} if self.reuse else {}),
            **({} if self.task.ego is None else {"ego": self.task.ego}),
        }


def get_method(name: str) -> Method:
    """Return the registered method of an id.

    Raises:
        AgentError: naming the known ids.
    """
    if name not in METHODS:
        raise AgentError(f"unknown method {name!r}{meant(name, METHODS)}; write one of: {', '.join(METHODS)}")
    return METHODS[name]


class Report(NamedTuple):
    """How far a training is: env steps done, and each seed's validation success rate, NaN where it has failed."""

    env_steps: int
    success: tuple[float, ...]

    @property
    def note(self) -> str:
        """The success rates in words."""
        return "validation success " + " ".join("failed" if isnan(rate) else f"{rate:.0%}" for rate in self.success)


def train(
    plan: Plan,
    *,
    resume: bool = False,
    extendable: bool = False,
    track: Sequence[str] = (),
    patience: float = PATIENCE,
) -> Iterator[Report]:
    """Yield the reports of a training; at its end the run directory holds the checkpoints.

    Args:
        plan: what to train, and where its files go.
        resume: go on with a training that was stopped, to the same bits as without the stop; a finished one has no
            more reports.
        extendable: leave the state of every seed behind, and, with ``resume``, go on from those of a finished training
            of fewer steps; see :mod:`hhrl_bench.training.extension`.
        track: names of the trackers that get the curves too; see :data:`hhrl_bench.training.trackers.TRACKERS`.
        patience: seconds for which another training of one of the seeds, in the same folder, may still be at work.

    Raises:
        OutputError: before training begins, if the run directory cannot be written, holds other runs, or a state that
            cannot be resumed, or another process trains one of the seeds there.
    """
    directory = RunDirectory(plan.folder)
    require_trackers(track)
    longer = resume and extendable and extends(plan, directory)
    if resume and not longer and directory.finished(plan.seeds):
        directory.require_config(plan.config())
        return
    training = _Training(plan, directory, extendable=extendable)  # what it lacks is said before anything is written
    with directory.at_work(plan.seeds, patience):
        if longer and extends(plan, directory):
            extend(plan, directory)
        if resume and directory.finished(plan.seeds):  # by the training that was waited for
            return
        directory.prepare(plan.config(), plan.seeds, resume=resume)
        yield from training.run(track)


class _Training:
    """A training under way: a learner for each seed, and what their reports have come to."""

    def __init__(self, plan: Plan, directory: RunDirectory, *, extendable: bool) -> None:
        self._plan, self._directory, self._extendable = plan, directory, extendable
        self._scenario = get_scenario(plan.task.scenario)
        self._learners = [self._learner(seed) for seed in plan.seeds]
        self._runs = [SeedRun(seed) for seed in plan.seeds]
        self._state_path = directory.state(plan.seeds)
        self._file = StateFile(self._state_path, plan.config())
        self._started = time.perf_counter()
        self._trackers: list[Tracker] = []

    def _learner(self, seed: int) -> Learner:
        plan = self._plan
        start = plan.reuse.start(plan.method, seed) if plan.reuse else NOTHING
        worlds = _world_seeds(plan.task, seed, plan.method.config.n_envs)
        arguments = plan.method, self._scenario, seed, worlds, training_drivers(plan.task), start
        if plan.engine == "compiled":
            return make_learner(*arguments)
        require("torch", "torch")
        from hhrl_agents.reference.learner import TorchLearner  # noqa: PLC0415

        return TorchLearner(*arguments, device=plan.device)

    def run(self, track: Sequence[str]) -> Iterator[Report]:
        if self._state_path.exists():
            self._resume()
        self._file.save_if_due(self._state)
        self._trackers += [TRACKERS[name](self._directory.folder, self._runs, self._plan.config()) for name in track]
        with _side_by_side(self._learners) as each:
            if not self._runs[0].curve:
                yield self._report([self._validated(index, _NOTHING_YET) for index in range(len(self._runs))])
            plan = self._plan
            trainings = [learner.train(plan.env_steps, plan.schedule_steps) for learner in self._learners]
            while going := [index for index, run in enumerate(self._runs) if self._goes_on(index, run)]:
                reports = each(lambda index: next(trainings[index]), going)
                yield self._report([*map(self._validated, going, reports)])
        self._finish()

    def _goes_on(self, index: int, run: SeedRun) -> bool:
        return not run.failed and self._learners[index].env_steps < self._plan.env_steps

    def _validated(self, index: int, progress: Progress) -> "_SeedReport":
        """Return a learner's report with its policy as it is now, and the policy's validation unless it has failed."""
        policy, row = self._learners[index].policy(), _row(progress)
        finite_parameters = all(bool(np.isfinite(value).all()) for value in policy.parameters.values())
        fault = find_fault(progress.losses, finite_parameters, progress.updates > self._runs[index].updates)
        fault = fault or progress.diverged
        if fault:
            return _SeedReport(index, {**row, "validation": None, "failed": fault}, policy)
        return _SeedReport(index, {**row, "validation": self._validate(policy)}, policy)

    def _resume(self) -> None:
        saved = self._file.load(self._plan.seeds)
        self._started -= saved.seconds
        if not saved.learner:
            return
        try:
            for learner in self._learners:
                learner.restore(below(saved.learner, str(learner.seed)))
        except (KeyError, TypeError, ValueError) as error:
            raise self._file.refuse_learner(error) from error
        self._runs = saved.runs

    def _state(self) -> TrainingState:
        states = {str(learner.seed): learner.state() or {} for learner in self._learners}
        return TrainingState(prefixed(states), self._runs, time.perf_counter() - self._started)

    def _report(self, reports: Sequence["_SeedReport"]) -> Report:
        """Write what the seeds have come to, and return it."""
        for place, row, policy in reports:
            run = self._runs[place]
            if "failed" in row:
                run.fail(row)
                self._directory.write_failure(run.seed, run.failure())
            else:
                self._keep(run, row, policy)
            self._directory.write_curve(run.seed, run.curve)
            for tracker in self._trackers:
                tracker.add(run.seed, run.curve[-1])
        self._file.save_if_due(self._state)
        return Report(reports[0].row["env_steps"], tuple(map(_success, self._runs)))

    def _validate(self, policy: LearnedAgent) -> dict[str, float | None]:
        seeds, drivers = self._plan.task.validation.take(VALIDATION_EPISODES), training_drivers(self._plan.task)
        metrics = watched()
        scored = play(policy, self._scenario, seeds, rows=len(seeds), drivers=drivers, metrics=metrics)
        return finite(means(scored.records, metrics))

    def _keep(self, run: SeedRun, row: ReportRow, policy: LearnedAgent) -> None:
        if run.add(row):
            self._save(self._directory.best(run.seed), run.seed, policy, row)

    def _save(self, path: Path, seed: int, policy: LearnedAgent, row: ReportRow) -> None:
        checkpoints.save(path, policy, {**self._plan.origin(seed), "validation": row["validation"]})

    def _finish(self) -> None:
        """Write the provenance and the last checkpoints; the state goes last, so that a kill loses nothing."""
        plan, elapsed = self._plan, time.perf_counter() - self._started
        record = provenance(plan.command, {f"{plan.task.id}/{plan.method.id}": elapsed})
        write_atomically(self._directory.provenance(plan.seeds), record.model_dump_json(indent=2) + "\n")
        for run, learner in zip(self._runs, self._learners, strict=True):
            if not run.failed:
                self._save(self._directory.final(run.seed), run.seed, learner.policy(), run.curve[-1])
                self._date_best(run)
            if self._extendable and (state := learner.state()) is not None:
                learned = TrainingState(prefixed({str(run.seed): state}), [run], elapsed)
                StateFile(self._directory.end_state(run.seed), plan.config()).save(learned)
        for tracker in self._trackers:
            tracker.close()
        self._state_path.unlink()

    def _date_best(self, run: SeedRun) -> None:
        """Let the chosen checkpoint of an extended training say of its training what all of them say."""
        if self._plan.span == self._plan.env_steps or run.best is None:
            return
        path, origin = self._directory.best(run.seed), self._plan.origin(run.seed)
        best = checkpoints.load(path)
        own = {name: value for name, value in best.metadata.items() if name not in {*origin, "validation"}}
        self._save(path, run.seed, make_agent(best.method, best.scenario, best.parameters, own), run.curve[run.best])


def find_fault(losses: Mapping[str, float], finite_parameters: bool, updated: bool) -> str | None:
    """Return why a seed has diverged, by its mean losses since its last report and its parameters; None if neither."""
    if not finite_parameters:
        return "its parameters are not finite"
    lost = [level for level, loss in losses.items() if updated and not isfinite(loss)]
    return f"its {lost[0]} loss is not finite" if lost else None


def _world_seeds(task: Task, seed: int, n_envs: int) -> Keys:
    """Return the training worlds [n_envs] of a seed: block k of the train range is seed k's."""
    return task.train.take(n_envs, offset=seed * n_envs)


class _SeedReport(NamedTuple):
    """A report of the seed at a place among the plan's, and the policy that it is about."""

    place: int
    row: ReportRow
    policy: LearnedAgent


_NOTHING_YET = Progress(0, 0, {}, np.zeros(len(Outcome), np.int64))

Each = Callable[[Callable[[int], Progress], Sequence[int]], Sequence[Progress]]
"""What calls a function with each of some indices, and returns the results in their order."""


@contextmanager
def _side_by_side(learners: Sequence[Learner]) -> Iterator[Each]:
    """Yield what calls a function for several learners, in as many threads as numba would use if they can run so.

    An interrupt does not wait for them.
    """
    threads = numba.get_num_threads() if all(learner.runs_in_threads for learner in learners) else 1
    executor = ThreadPoolExecutor(min(threads, len(learners)))
    try:
        yield lambda function, indices: list(executor.map(function, indices))
    finally:
        executor.shutdown(wait=False, cancel_futures=True)


def _row(progress: Progress) -> dict[str, Any]:
    counts = progress.outcome_counts
    return {
        "env_steps": progress.env_steps,
        "updates": progress.updates,
        "losses": finite(progress.losses),
        "episodes": {outcome.name.lower(): int(counts[outcome]) for outcome in Outcome if counts[outcome]},
    }


def _success(run: SeedRun) -> float:
    return nan if run.failed else float(run.curve[-1]["validation"]["success"])
