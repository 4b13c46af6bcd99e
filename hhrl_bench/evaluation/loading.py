"""Agents by name: registered rules and methods, checkpoints, run directories and users' factories."""

import hashlib
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import ValidationError

from hhrl_agents import METHODS, RULES, Agent
from hhrl_agents.policies.checkpoint_file import SHIPPED
from hhrl_bench.errors import AgentError
from hhrl_bench.evaluation.factories import require_module
from hhrl_bench.evaluation.guarded_agent import guarded
from hhrl_bench.evaluation.records import TrainingRecord
from hhrl_bench.isolation.agent_process import AgentProcess
from hhrl_bench.schema import first_problem
from hhrl_bench.tasks.tasks import Task, get_task
from hhrl_bench.text import meant
from hhrl_envs import Scenario, get_scenario

Kind = Literal["rule", "learned", "factory"]

_SERVER = "hhrl_bench.evaluation.agent_server"
"""What runs in the process of a user's agent."""


@dataclass(frozen=True)
class LoadedAgent:
    """An agent ready to drive; a learned one with its checkpoint's sha256, path and training.

    One that a user's factory makes is in a process of its own, which ends with this as a context.
    """

    kind: Kind
    agent: Agent
    sha256: str | None = None
    training: TrainingRecord | None = None
    path: Path | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if isinstance(self.agent, AgentProcess):
            self.agent.close()


def load_agent(source: str | Path, task: str | Task = "stop-line-v0") -> Agent:
    """Return the agent that ``source`` names, ready for ``task``; of several training seeds, the lowest.

    One that ``module:factory`` makes runs in a process of its own, until nobody holds what is returned here.

    Args:
        source: a registered name, a checkpoint file, a run directory, or ``module:factory``.
        task: a task or its id.

    Raises:
        InputError: in one line, where there is no such agent or it does not fit the task.
    """
    return load_agents(source, get_scenario(get_task(task).scenario))[0].agent


def load_agents(source: str | Path, scenario: Scenario) -> list[LoadedAgent]:
    """Return what ``source`` names: one agent, or one for each training seed, lowest first; see :func:`load_agent`."""
    name = str(source)
    if _names_factory(name):
        require_module(name)
        return [LoadedAgent("factory", AgentProcess(_SERVER, name, scenario))]
    if name in RULES:
        return [LoadedAgent("rule", guarded(lambda: RULES[name](scenario), "constructor"))]
    if name in METHODS:
        return _load_shipped(name, scenario)
    path = Path(source)
    if _holds(path.is_dir):
        return _load_directory(path, scenario)
    if _holds(path.is_file) and path.suffix != ".py":
        return [_load_checkpoint(path, scenario)]
    if path.suffix == ".py":
        raise AgentError(f"{name!r} is a file of Python; write module:factory, such as {path.stem}:make_agent")
    known = [*RULES, *shipped_methods()]
    raise AgentError(
        f"unknown agent {name!r}{meant(name, known)}; write a checkpoint file, a run directory, module:factory, "
        f"or one of: {', '.join(known)}"
    )


def _names_factory(name: str) -> bool:
    path = Path(name)
    if ":" not in name or name in RULES or name in METHODS:
        return False
    return not _holds(path.is_dir) and not (_holds(path.is_file) and path.suffix != ".py")


def require_playable(sources: Sequence[str], task: Task) -> None:
    """Raise an ``AgentError``, before anything is run, for an agent that is named twice or is plainly not there.

    What a factory makes is seen when that agent's turn comes, so that one which fails keeps no other from being scored.
    """
    twice = next((source for source in sources if sources.count(source) > 1), None)
    if twice is not None:
        raise AgentError(f"agent {twice!r} is named twice; name each agent once")
    for source in sources if len(sources) > 1 else ():  # a single one is loaded and played at once
        if _names_factory(source):
            require_module(source)
        else:
            load_agents(source, get_scenario(task.scenario))


def require_loadable(source: str, task: Task) -> None:
    """Raise an ``InputError`` if an agent does not load."""
    for loaded in load_agents(source, get_scenario(task.scenario)):
        with loaded:
            pass


def _holds(check: Callable[[], bool]) -> bool:
    try:
        return check()
    except OSError:  # a name that is too long for a file, or a folder that must not be looked into
        return False


def shipped_methods() -> dict[str, int]:
    """Return how many trained seeds come with the package, for every method that has some."""
    counts = {method: len(shipped_checkpoints(method)) for method in METHODS}
    return {method: count for method, count in counts.items() if count}


def shipped_checkpoints(method: str) -> list[Path]:
    """Return the trained seeds of a method that come with the package, lowest first."""
    return _checkpoints(SHIPPED / method)


def _load_shipped(method: str, scenario: Scenario) -> list[LoadedAgent]:
    if method not in shipped_methods():
        raise AgentError(f"no trained {method} comes with the package; train it: hhrl-bench train {method}")
    return _load_directory(SHIPPED / method, scenario)


def _load_directory(folder: Path, scenario: Scenario) -> list[LoadedAgent]:
    paths = _checkpoints(folder)
    if not paths:
        raise AgentError(f"{folder} holds no seed-<k>.safetensors; name a folder that hhrl-bench train has filled")
    return [_load_checkpoint(path, scenario) for path in paths]


def _checkpoints(folder: Path) -> list[Path]:
    """Return the chosen checkpoints in a folder, lowest seed first."""
    named = ((re.fullmatch(r"seed-([0-9]{1,9})\.safetensors", path.name), path) for path in folder.glob("seed-*"))
    return [path for _, path in sorted((int(match[1]), path) for match, path in named if match)]


def _load_checkpoint(path: Path, scenario: Scenario) -> LoadedAgent:
    from hhrl_agents.policies import checkpoints  # noqa: PLC0415

    agent = checkpoints.load(path)
    _require_fit(agent.metadata, scenario, path)
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    return LoadedAgent("learned", agent, digest, training_record(agent.metadata, path), path)


def training_record(metadata: Mapping[str, Any], path: Path) -> TrainingRecord:
    """Return what a checkpoint's metadata say of its training.

    Raises:
        AgentError: if that cannot be.
    """
    data = {name: metadata.get(name) for name in TrainingRecord.model_fields}
    try:
        return TrainingRecord.model_validate(data)
    except ValidationError as error:
        raise AgentError(f"{path} says of its training what cannot be: {first_problem(error)}") from error


def _require_fit(metadata: Mapping[str, Any], scenario: Scenario, path: Path) -> None:
    if metadata["interface_hash"] != scenario.interface_hash:
        raise AgentError(
            f"{path} sees or acts otherwise than {scenario.id} asks: its interface hash is "
            f"{metadata['interface_hash']}, the scenario's {scenario.interface_hash}"
        )
    trained_in = scenario if metadata["scenario"] == scenario.id else get_scenario(metadata["scenario"])
    if metadata["spec_hash"] != trained_in.spec_hash:
        raise AgentError(
            f"{path} was trained in another version of {trained_in.id}: its spec hash is {metadata['spec_hash']}, "
            f"this version's {trained_in.spec_hash}; train it again"
        )
