"""Tasks: a scenario with a training budget and the seeds of its worlds, as data under versioned ids."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from hhrl_bench.errors import UnknownTaskError
from hhrl_bench.tasks.own import add_own, find_own
from hhrl_bench.tasks.seeds import SeedRange, consecutive_ranges
from hhrl_bench.text import meant
from hhrl_envs import SCENARIOS, Scenario, get_scenario
from hhrl_envs.scenario.registry import SUMMARIES, SUPERSEDED, add_scenario

TRAIN, VALIDATION, TEST = consecutive_ranges("train", "validation", "test")

SCRIPTED = "scripted"


@dataclass(frozen=True, slots=True)
class Task:
    """A benchmark task; a new version of it gets a new id.

    Attributes:
        id: versioned name, as the command line spells it.
        scenario: id of the world it is played in.
        env_steps: training budget of one seed, in environment steps.
        given_actions: whether the action level is given, by the stop controller and the trained `follow-only`.
        shared: whether one policy drives the ego and all learned front vehicles; an episode succeeds if all of them do.
        opponent: the agent that drives the nearest front vehicle of an ego that is scored; None: a script.
        ego: the agent that drives the ego where the nearest front vehicle is what is trained; None: the ego is.
        train: worlds to learn from.
        validation: worlds to choose checkpoints by.
        test: worlds to score on; episode i of a test set is the world of seed ``test.start + i`` for every agent.
    """

    id: str
    scenario: str
    env_steps: int
    given_actions: bool = False
    shared: bool = False
    opponent: str | None = None
    ego: str | None = None
    train: SeedRange = field(default=TRAIN, init=False)
    validation: SeedRange = field(default=VALIDATION, init=False)
    test: SeedRange = field(default=TEST, init=False)

    def against(self, opponent: str | None) -> "Task":
        """Return the task with another opponent, an agent or `SCRIPTED`; with its own one for None.

        Raises:
            UnknownTaskError: if the task has no opponent.
        """
        if opponent is None:
            return self
        if self.opponent is None:
            raise UnknownTaskError(f"{self.id} has no opponent; leave out --opponent, or write --task adversary-v0")
        return replace(self, opponent=None if opponent == SCRIPTED else opponent)

    def __reduce__(self) -> tuple[Any, ...]:
        """Take the scenario along to other processes, in which it may not be registered."""
        given = {one.name: getattr(self, one.name) for one in fields(self) if one.init}
        return _restored, (get_scenario(self.scenario), given)


def _restored(scenario: Scenario, given: dict[str, Any]) -> Task:
    add_scenario(scenario)
    return Task(**given)


_MILD = ("stop-line-v0", "stop-line-paper-v0", "stop-line-heldout-v0", "solo-stop-v0", "follow-v0", "red-light-v0")
_BUDGETS = dict.fromkeys((*_MILD, "platoon-v0", "adversary-v0"), 300_000)
_DEFAULT_BUDGET = 1_000_000

_DECLARED = (Task("option-only-v0", "stop-line-v0", env_steps=300_000, given_actions=True),)
"""Tasks that are more than their scenario."""


class _Tasks(Mapping[str, Task]):
    """The tasks by id, derived from the scenarios that are registered when they are looked up."""

    def __getitem__(self, task_id: str) -> Task:
        return self._by_id()[task_id]

    def __iter__(self) -> Iterator[str]:
        return iter(self._by_id())

    def __len__(self) -> int:
        return len(self._by_id())

    @staticmethod
    def _by_id() -> dict[str, Task]:
        alone = [_task_of(one) for one in SCENARIOS.values() if not one.learned_fronts]
        several = [_task_of(one) for one in SCENARIOS.values() if one.learned_fronts]
        return {task.id: task for task in (*alone, *_DECLARED, *several)}


def _task_of(scenario: Scenario) -> Task:
    """Return a scenario as a task: learned fronts are driven by the ego's policy, an adversary by its own."""
    budget, has_adversary = _BUDGETS.get(scenario.id, _DEFAULT_BUDGET), scenario.adversary is not None
    return Task(
        scenario.id,
        scenario.id,
        env_steps=budget,
        shared=bool(scenario.learned_fronts) and not has_adversary,
        opponent="adversary" if has_adversary else None,
        ego="ddqn" if has_adversary else None,
    )


TASKS: Mapping[str, Task] = _Tasks()
"""Every registered scenario as a task of the same id, and `option-only-v0`, whose action level is given."""


def summary_of(task: Task) -> str:
    """Return what is special in a task, in a few words; empty where nobody has said it."""
    said = "the action level is given; " if task.given_actions else ""
    summary = said + SUMMARIES.get(task.scenario, "")
    newer = SUPERSEDED.get(task.scenario)
    return f"superseded by {newer}: {summary}" if newer else summary


AnyTask = str | Path | Scenario | Task
"""What names a task; see :func:`get_task`."""


def registered_task(task_id: str) -> Task:
    """Return the task of an id, whoever has written it: no file is read and no module imported.

    Raises:
        UnknownTaskError: naming the known ids.
    """
    if task_id not in TASKS:
        raise UnknownTaskError(
            f"unknown task {task_id!r}{meant(task_id, TASKS)}; known tasks: {', '.join(TASKS)}; "
            "a task of your own is a scenario file or module:scenario"
        )
    return TASKS[task_id]


def get_task(task: AnyTask) -> Task:
    """Return the task that is named; a scenario of a user's own is registered, and becomes the task of its id.

    Args:
        task: a registered id, a scenario file, ``module:scenario``, a scenario, or a task, which is returned as it is.

    Raises:
        InputError: in one line, if there is no such task, or it would pass for a registered one.
    """
    if isinstance(task, Task):
        return task
    own = task if isinstance(task, Scenario) else None if task in TASKS else find_own(str(task))
    if own is None:
        return registered_task(str(task))
    add_own(own, [one.id for one in _DECLARED])
    return registered_task(own.id)


def distinct_tasks(names: Sequence[str]) -> list[Task]:
    """Return the tasks of these names.

    Raises:
        InputError: in one line, for a name of no task, or a task that is named twice.
    """
    tasks = [get_task(name) for name in names]
    for place, task in enumerate(tasks):
        if task in tasks[:place]:
            raise UnknownTaskError(f"task {task.id!r} is named twice; name each task once")
    return tasks
