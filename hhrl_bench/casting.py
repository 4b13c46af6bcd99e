"""Who drives which vehicle when an agent is scored on a task, and when one is trained for it."""

from hhrl_agents.cast import EGO_ALONE, Cast
from hhrl_bench.loading import LoadedAgent, load_agents
from hhrl_bench.players import Player
from hhrl_bench.tasks import Task
from hhrl_envs import get_scenario

_EGO, _FRONT = 0, 1


def evaluation_cast(task: Task) -> Cast:
    """Return who drives when an agent is scored: it is the ego, or all vehicles where the task is shared."""
    opponent = load_opponent(task)
    if opponent is not None:
        return Cast((_EGO,), {_FRONT: Player(opponent.agent, get_scenario(task.scenario).num_actions)})
    return _all_vehicles(task) if task.shared else EGO_ALONE


def evaluation_slots(task: Task) -> tuple[int, ...]:
    """Return the vehicles that an agent drives when it is scored."""
    return _all_vehicles(task).slots if task.shared else EGO_ALONE.slots


def training_cast(task: Task) -> Cast:
    """Return who drives when an agent is trained: it is the front vehicle where the task has an ego to train against.

    Raises:
        InputError: if no such ego comes with the package.
    """
    if task.ego is not None:
        return Cast((_FRONT,), {_EGO: _load(task.ego, task).agent})
    return _all_vehicles(task) if task.shared else EGO_ALONE


def load_opponent(task: Task) -> LoadedAgent | None:
    """Return the agent that drives the nearest front vehicle of the task, None where that is scripted."""
    return None if task.opponent is None else _load(task.opponent, task)


def _load(source: str, task: Task) -> LoadedAgent:
    return load_agents(source, get_scenario(task.scenario))[0]


def _all_vehicles(task: Task) -> Cast:
    return Cast(tuple(range(1 + (get_scenario(task.scenario).learned_fronts or 0))))
