"""Tasks: a scenario with a training budget and the seeds of its worlds, as data under versioned ids."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from hhrl_bench.errors import UnknownTaskError
from hhrl_bench.seeds import SeedRange, consecutive_ranges
from hhrl_envs import SCENARIOS

TRAIN, VALIDATION, TEST = consecutive_ranges("train", "validation", "test")


@dataclass(frozen=True, slots=True)
class Task:
    """A benchmark task; a new version of it gets a new id.

    Attributes:
        id: versioned name, as the command line spells it.
        scenario: id of the world it is played in.
        env_steps: training budget of one seed, in environment steps.
        given_actions: whether the action level is given, by the stop controller and the trained `follow-only`.
        train: worlds to learn from.
        validation: worlds to choose checkpoints by.
        test: worlds to score on; episode i of a test set is the world of seed ``test.start + i`` for every agent.
    """

    id: str
    scenario: str
    env_steps: int
    given_actions: bool = False
    train: SeedRange = field(default=TRAIN, init=False)
    validation: SeedRange = field(default=VALIDATION, init=False)
    test: SeedRange = field(default=TEST, init=False)


_MILD = ("stop-line-v0", "stop-line-paper-v0", "stop-line-heldout-v0", "solo-stop-v0", "follow-v0", "red-light-v0")
_BUDGETS = dict.fromkeys(_MILD, 300_000)
_WORLDS = [world for world in SCENARIOS.values() if not world.learned_fronts]

TASKS: Mapping[str, Task] = MappingProxyType(
    {
        task.id: task
        for task in (
            *(Task(world.id, world.id, env_steps=_BUDGETS.get(world.id, 1_000_000)) for world in _WORLDS),
            Task("option-only-v0", "stop-line-v0", env_steps=300_000, given_actions=True),
        )
    }
)
"""Every registered scenario in which the ego is the only agent, as a task of the same id; and `option-only-v0`, whose
action level is given."""


def get_task(task: str | Task) -> Task:
    """Return the task of an id; a task is returned as it is.

    Raises:
        UnknownTaskError: naming the known ids.
    """
    if isinstance(task, Task):
        return task
    try:
        return TASKS[task]
    except KeyError:
        raise UnknownTaskError(f"unknown task {task!r}; known tasks: {', '.join(TASKS)}") from None


def get_world(world: str | Task) -> Task:
    """Return the task of an id or, where there is none, the worlds of the scenario of that id, to look at.

    In a scenario that is made for learned front vehicles all of them are scripted here, so it is no task to score on.

    Raises:
        UnknownTaskError: naming the known ids.
    """
    if isinstance(world, str) and world in SCENARIOS and world not in TASKS:
        return Task(world, scenario=world, env_steps=1)
    return get_task(world)
