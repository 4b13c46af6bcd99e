"""Extending a finished training: its seeds go on from the states that they were left in.

Exploration and learning rate change over a span of steps, which is the first budget, and stay as they are beyond it. So
a training that is extended leaves the files of one that was longer from the start and had that span.
"""

from collections.abc import Mapping
from itertools import pairwise
from typing import Any, Protocol

from hhrl_agents.atomic_files import OutputError
from hhrl_agents.methods.method import Method
from hhrl_bench.training.run_directory import RunDirectory, as_read
from hhrl_bench.training.saved_state import SeedRun, StateFile, TrainingState

_STEPS = ("env_steps", "schedule_steps")


class Planned(Protocol):
    """What is known of a training; see :class:`hhrl_bench.training.train.Plan`."""

    @property
    def method(self) -> Method:
        """The method."""

    @property
    def seeds(self) -> tuple[int, ...]:
        """Training seeds."""

    @property
    def env_steps(self) -> int:
        """Budget of a seed."""

    @property
    def span(self) -> int:
        """Over how many steps exploration and learning rate change."""

    def config(self) -> dict[str, Any]:
        """Return what all seeds share, as JSON data."""


def span_of(plan: Planned, directory: RunDirectory) -> int | None:
    """Return the span of the schedules of the same training in a folder, if one of no more steps is there."""
    held = directory.config()
    return _span(held) if _is_alike(held, plan) and held["env_steps"] <= plan.env_steps else None


def extends(plan: Planned, directory: RunDirectory) -> bool:
    """Return whether a plan is that of the training in its folder, but longer.

    Raises:
        OutputError: if it is shorter, or has another span of the schedules.
    """
    held = directory.config()
    if not _is_alike(held, plan) or held["env_steps"] == plan.env_steps:
        return False
    if held["env_steps"] > plan.env_steps:
        raise OutputError(
            f"{directory.folder} holds a training of {held['env_steps']:,} steps already; ask for more to go on with "
            "it, or name another folder with --out"
        )
    if _span(held) != plan.span:
        raise OutputError(
            f"cannot extend {directory.folder}: its exploration and learning rate change over {_span(held):,} steps; "
            f"leave out --schedule-steps, or train anew in another folder with --out"
        )
    return True


def extend(plan: Planned, directory: RunDirectory) -> None:
    """Make the finished training in a plan's folder the plan's own, unfinished, at the state that it was left in.

    If this is stopped it can be done again.

    Raises:
        OutputError: if a seed there is not of the plan, or cannot go on; nothing is changed then.
    """
    others = sorted(set(directory.ended_seeds()) - set(plan.seeds))
    if others:
        raise OutputError(
            f"cannot extend {directory.folder}: it holds seed {others[0]} too, and all seeds of a folder have one "
            "budget; name all of them with --seeds"
        )
    held, unfinished = directory.config(), directory.state(plan.seeds)
    if unfinished.exists() and not StateFile(unfinished, plan.config()).holds(plan.seeds):
        raise OutputError(
            f"cannot extend {directory.folder}: its training is not finished; finish it first, by the same command "
            f"with --env-steps {held['env_steps']}"
        )
    states = [_end_state(directory, held, plan, seed) for seed in plan.seeds]
    joined: dict[str, Any] = {}
    for state in states:
        joined |= state.learner
    runs, seconds = [run for state in states for run in state.runs], max(state.seconds for state in states)
    StateFile(unfinished, plan.config()).save(TrainingState(joined, runs, seconds))
    directory.write_config(plan.config())


def _end_state(directory: RunDirectory, held: Mapping[str, Any], plan: Planned, seed: int) -> TrainingState:
    path = directory.end_state(seed)
    if not path.exists():
        raise OutputError(
            f"cannot extend {directory.folder}: seed {seed} has left no state there; a training of {plan.env_steps:,} "
            "steps has to begin anew, in another folder with --out"
        )
    state = StateFile(path, held).load((seed,))
    (run,) = state.runs
    if not run.failed and not _ends_at_a_report(run, plan.method.config.report_every):
        raise OutputError(
            f"cannot extend {directory.folder}: it ended at {held['env_steps']:,} steps, and a longer training reports "
            f"every {plan.method.config.report_every:,} steps, so it would choose among other policies; train anew in "
            "another folder with --out"
        )
    return state


def _ends_at_a_report(run: SeedRun, every: int) -> bool:
    """Return whether a longer training would have its last report too: it came as a multiple was reached."""
    steps = [int(row["env_steps"]) for row in run.curve[-2:]]
    return all(last // every > before // every for before, last in pairwise(steps))


def _is_alike(held: Mapping[str, Any], plan: Planned) -> bool:
    """Return whether a config is that of a plan, however many steps they have."""
    return isinstance(held.get("env_steps"), int) and _without_steps(held) == _without_steps(as_read(plan.config()))


def _without_steps(config: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in config.items() if name not in _STEPS}


def _span(config: Mapping[str, Any]) -> int:
    return int(config.get("schedule_steps", config["env_steps"]))
