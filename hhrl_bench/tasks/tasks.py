"""Tasks: a scenario with a training budget and the seeds of its worlds, as data under versioned ids."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from hhrl_bench.errors import UnknownTaskError
from hhrl_bench.tasks.seeds import SeedRange, consecutive_ranges
from hhrl_envs import SCENARIOS

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


_MILD = ("stop-line-v0", "stop-line-paper-v0", "stop-line-heldout-v0", "solo-stop-v0", "follow-v0", "red-light-v0")
_BUDGETS = dict.fromkeys(_MILD, 300_000)
_WORLDS = [world for world in SCENARIOS.values() if not world.learned_fronts]

TASKS: Mapping[str, Task] = MappingProxyType(
    {
        task.id: task
        for task in (
            *(Task(world.id, world.id, env_steps=_BUDGETS.get(world.id, 1_000_000)) for world in _WORLDS),
            Task("option-only-v0", "stop-line-v0", env_steps=300_000, given_actions=True),
            Task("platoon-v0", "platoon-v0", env_steps=300_000, shared=True),
            Task("adversary-v0", "adversary-v0", env_steps=300_000, opponent="adversary", ego="ddqn"),
        )
    }
)
"""Every registered scenario as a task of the same id, and `option-only-v0`, whose action level is given."""


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
