"""Episodes as a Minari dataset: every observation, action, reward and info, made again from the decisions.

Where agents drive one vehicle, the dataset is that of the scenario's Gymnasium environment. Where they drive
several, observations and actions are by the names of PettingZoo's agents, ``rewards`` add up those of the vehicles that
the scored agent drives, and ``infos`` hold each vehicle's own.
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from hhrl_agents.atomic_files import OutputError, write_folder_atomically
from hhrl_bench.evaluation.paired_evaluation import evaluation_slots
from hhrl_bench.exports.episodes import Run, profiles_of, worlds
from hhrl_bench.exports.transitions import VehicleSteps, agent_names, transitions
from hhrl_bench.tasks.tasks import Task
from hhrl_bench.text import file_name
from hhrl_envs import Outcome, Scenario, get_scenario
from hhrl_envs.errors import require
from hhrl_envs.views.gym_env import gym_id
from hhrl_envs.views.spaces import observation_space

NAMESPACE = "hhrl"
"""What the ids of datasets begin with."""


def dataset_id(agent: str, task: str) -> str:
    """Return the id of the dataset of an agent on a task, such as ``hhrl/stop-line-v0/rule-4-v0``."""
    return f"{NAMESPACE}/{file_name(task)}/{file_name(agent)}-v0"


def write_dataset(runs: Sequence[Run], root: Path) -> str:
    """Write the episodes of an agent's runs on a task as a dataset into a folder of Minari datasets; return its id.

    The same episodes give the same bytes. ``MINARI_DATASETS_PATH`` has to name the folder when it is loaded.

    Raises:
        InputError: in one line, if Minari is missing, or there is such a dataset already.
    """
    require_minari()
    name = dataset_id(runs[0].agent, runs[0].task.id)
    folder = root / name
    if folder.exists():
        raise OutputError(f"{folder} is there already; remove it, or name another folder")
    write_folder_atomically(folder, lambda place: _write(runs, name, place.absolute() / "data"))
    return name


def require_minari() -> None:
    """Raise a ``MissingExtraError`` unless all is installed that a dataset needs."""
    for module in ("minari", "h5py", "PIL"):
        require(module, "minari")


def _write(runs: Sequence[Run], name: str, place: Path) -> None:
    from minari.data_collector import EpisodeBuffer  # noqa: PLC0415
    from minari.dataset.minari_storage import MinariStorage  # noqa: PLC0415

    task = runs[0].task
    scenario, agents = get_scenario(task.scenario), agent_names(runs[0])
    place.mkdir(parents=True)
    storage = MinariStorage.new(place, **_spaces(scenario, agents))
    storage.update_metadata(_metadata(runs, name, agents))
    for run in runs:
        buffers = (EpisodeBuffer(**_buffer(task, agents, episode)) for episode in transitions(run))
        storage.update_episodes(buffers)
    storage.update_episode_metadata([one for run in runs for one in _of_episodes(run)])


def _spaces(scenario: Scenario, agents: Sequence[str]) -> dict[str, Any]:
    seen, done = observation_space(scenario), spaces.Discrete(scenario.num_actions)
    if len(agents) == 1:
        return {"observation_space": seen, "action_space": done, "env_spec": gymnasium.spec(gym_id(scenario.id))}
    each = {"observation_space": seen, "action_space": done}
    return {name: spaces.Dict(dict.fromkeys(agents, space)) for name, space in each.items()}


def _metadata(runs: Sequence[Run], name: str, agents: Sequence[str]) -> dict[str, Any]:
    import minari  # noqa: PLC0415

    task = runs[0].task
    said = f"{runs[0].agent} on the test episodes of {task.id}"
    several = f"; agents: {', '.join(agents)}, of a PettingZoo environment" if len(agents) > 1 else ""
    return {
        "dataset_id": name,
        "minari_version": minari.__version__,
        "algorithm_name": runs[0].agent,
        "description": said + several,
        "requirements": ["hhrl-bench"],
        "scenario": task.scenario,
        "spec_hash": get_scenario(task.scenario).spec_hash,
    }


def _of_episodes(run: Run) -> Iterator[dict[str, Any]]:
    """Yield what is to be known of every episode; a training seed of -1 is that of an agent without one."""
    for index, world in enumerate(worlds(run.task, run.worlds)):
        yield {
            "training_seed": -1 if run.seed is None else run.seed,
            "episode": index,
            "outcome": Outcome(int(run.outcome[index])).name.lower(),
            "profiles": profiles_of(world),
            "friction": world.friction,
        }


def _buffer(task: Task, agents: Sequence[str], episode: tuple[int, Mapping[str, VehicleSteps]]) -> dict[str, Any]:
    """Return what the buffer of an episode is made of, given the seed of its world and its steps."""
    seed, steps = episode
    if len(agents) == 1:
        own = steps[agents[0]]
        return {
            "seed": seed,
            "observations": own.observations,
            "actions": own.actions,
            "rewards": own.rewards,
            "terminations": own.terminated,
            "truncations": own.truncated,
            "infos": _infos(own),
        }
    scored = [steps[agents[slot]] for slot in evaluation_slots(task)]
    last = np.arange(len(scored[0].rewards)) == len(scored[0].rewards) - 1
    timed_out = any(bool(one.truncated.any()) for one in scored)
    return {
        "seed": seed,
        "observations": {name: one.observations for name, one in steps.items()},
        "actions": {name: one.actions for name, one in steps.items()},
        "rewards": np.sum([one.rewards for one in scored], axis=0),
        "terminations": last & (not timed_out),
        "truncations": last & timed_out,
        "infos": {name: {**_infos(one), **_of_several(one)} for name, one in steps.items()},
    }


def _infos(one: VehicleSteps) -> dict[str, NDArray[Any]]:
    """Return the infos [T + 1, ...], of which the first is that of the reset."""
    return {
        "option": _after_reset(one.options, -1),
        "reward_option": _after_reset(one.reward_option, 0.0),
        "reward_action": _after_reset(one.reward_action, 0.0),
        "outcome": _after_reset(one.outcomes, int(Outcome.RUNNING)),
    }


def _of_several(one: VehicleSteps) -> dict[str, NDArray[Any]]:
    """Return the infos that one of several agents has besides: its own reward and whether its episode ended."""
    return {
        "reward": _after_reset(one.rewards, 0.0),
        "terminated": _after_reset(one.terminated, 0),
        "truncated": _after_reset(one.truncated, 0),
        "active": _after_reset(one.active, 1),
    }


def _after_reset(values: NDArray[Any], nothing: float) -> NDArray[Any]:
    """Return the values [T, ...] behind what stands for them at the reset."""
    return np.concatenate([np.full((1, *values.shape[1:]), nothing, values.dtype), values])
