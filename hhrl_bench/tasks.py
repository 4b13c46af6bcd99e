"""Tasks: a scenario with a training budget and the seeds of its worlds, as data under versioned ids."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from hhrl_bench.errors import UnknownTaskError
from hhrl_bench.seeds import SeedRange, consecutive_ranges
from hhrl_envs.tiers import TIERS

TRAIN, VALIDATION, TEST = consecutive_ranges("train", "validation", "test")


@dataclass(frozen=True, slots=True)
class Task:
    """A benchmark task; a new version of it gets a new id.

    Attributes:
        id: versioned name, as the command line spells it.
        scenario: id of the world it is played in.
        env_steps: training budget of one seed, in environment steps.
        train: worlds to learn from.
        validation: worlds to choose checkpoints by.
        test: worlds to score on; episode i of a test set is the world of seed ``test.start + i`` for every agent.
    """

    id: str
    scenario: str
    env_steps: int
    train: SeedRange = field(default=TRAIN, init=False)
    validation: SeedRange = field(default=VALIDATION, init=False)
    test: SeedRange = field(default=TEST, init=False)


TASKS: Mapping[str, Task] = MappingProxyType(
    {
        task.id: task
        for task in (
            Task("stop-line-v0", scenario="stop-line-v0", env_steps=300_000),
            Task("follow-v0", scenario="follow-v0", env_steps=300_000),
            Task("red-light-v0", scenario="red-light-v0", env_steps=300_000),
            Task("option-only-v0", scenario="stop-line-v0", env_steps=300_000),
            Task("stop-line-paper-v0", scenario="stop-line-paper-v0", env_steps=300_000),
            *(Task(tier.id, scenario=tier.id, env_steps=1_000_000) for tier in TIERS),
        )
    }
)


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
