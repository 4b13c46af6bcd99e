"""Agents by name: registered rules and methods, checkpoints, run directories, users' factories and files."""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any, Self

from pydantic import ValidationError

from hhrl_agents import ORACLES, RULES, Agent
from hhrl_agents.adapters.files import ENDINGS
from hhrl_bench.errors import AgentError
from hhrl_bench.evaluation.factories import require_module
from hhrl_bench.evaluation.guarded_agent import guarded
from hhrl_bench.evaluation.records import Kind, TrainingRecord
from hhrl_bench.evaluation.sources import (
    names_file,
    own_seeds,
    policy_files,
    runs_apart,
    shipped_checkpoints,
    shipped_methods,
)
from hhrl_bench.isolation.agent_process import AgentProcess
from hhrl_bench.schema import first_problem
from hhrl_bench.tasks.tasks import AnyTask, Task, get_task
from hhrl_bench.text import meant
from hhrl_envs import Scenario, get_scenario

_SERVER = "hhrl_bench.evaluation.agent_server"
"""What runs in the process of a user's agent."""


@dataclass(frozen=True)
class LoadedAgent:
    """An agent ready to drive, of a training seed if it has one; a learned one with its checkpoint's sha256 and path.

    A user's own one is in a process of its own, which begins when it is first asked for, and ends with this as a
    context.
    """

    kind: Kind
    make: Callable[[], Agent]
    sha256: str | None = None
    training: TrainingRecord | None = None
    path: Path | None = None
    own_seed: int | None = None

    @property
    def seed(self) -> int | None:
        """The training seed: that of the checkpoint, or of a user's own agent among several; None without one."""
        return self.training.seed if self.training else self.own_seed

    @cached_property
    def agent(self) -> Agent:
        """The agent itself."""
        return self.make()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if isinstance(made := self.__dict__.get("agent"), AgentProcess):
            made.close()


def load_agent(source: str | Path, task: AnyTask = "stop-line-v0") -> Agent:
    """Return the agent that ``source`` names, ready for ``task``; of several training seeds, the lowest.

    A user's own, which a factory makes or a file of another library holds, runs in a process of its own, until nobody
    holds what is returned here.

    Args:
        source: a registered name, ``METHOD:SEEDS`` of seeds that come with the package, the file of a policy (a
            checkpoint, a zip of Stable-Baselines3, an ONNX file), several with commas between them, a folder of them,
            ``module:factory``, or ``module:factory@SEEDS``.
        task: what names a task; see :func:`hhrl_bench.tasks.tasks.get_task`.

    Raises:
        InputError: in one line, where there is no such agent or it does not fit the task.
    """
    return load_agents(source, get_scenario(get_task(task).scenario))[0].agent


def load_agents(source: str | Path, scenario: Scenario) -> list[LoadedAgent]:
    """Return what ``source`` names: one agent, or one for each training seed, lowest first; see :func:`load_agent`."""
    name = str(source)
    apart = runs_apart(name)
    if apart:
        return _load_apart(apart, scenario)
    if make := {**RULES, **ORACLES}.get(name):
        made = guarded(lambda: make(scenario), "constructor")
        return [LoadedAgent("rule" if name in RULES else "oracle", lambda: made)]
    paths = shipped_checkpoints(name) or policy_files(name)
    if not paths:
        raise _unknown(name)
    return _of_one_training([_load_checkpoint(path, scenario) for path in paths], name)


def _of_one_training(loaded: list[LoadedAgent], name: str) -> list[LoadedAgent]:
    """Return the agents by their training seeds, which have to be different ones of the same method."""
    trained = [(one.training.seed, one.training.config_hash) for one in loaded if one.training]
    if len({config for _, config in trained}) > 1 or len({seed for seed, _ in trained}) < len(trained):
        raise AgentError(f"{name!r} holds no training seeds of one method; name different seeds of the same training")
    return [one for _, one in sorted(zip(trained, loaded, strict=True), key=lambda pair: pair[0])]


def _load_apart(sources: Sequence[str], scenario: Scenario) -> list[LoadedAgent]:
    _require_there(sources)
    loaded = [
        LoadedAgent("factory", partial(AgentProcess, _SERVER, source, scenario), own_seed=seed)
        for source, seed in zip(sources, own_seeds(sources), strict=True)
    ]
    _ = loaded[0].agent  # what is wrong with the first is said now
    return loaded


def _require_there(sources: Sequence[str]) -> None:
    """Raise an ``AgentError`` if the module is not there that sources of agents in processes of their own name."""
    if not names_file(sources[0]):
        require_module(sources[0])


def _unknown(name: str) -> AgentError:
    path = Path(name)
    if path.suffix == ".py":
        return AgentError(f"{name!r} is a file of Python; write module:factory, such as {path.stem}:make_agent")
    if path.suffix in {*ENDINGS, ".safetensors"}:
        return AgentError(f"there is no file {name}; name the file of a policy that is there")
    known = [*RULES, *ORACLES, *shipped_methods()]
    return AgentError(
        f"unknown agent {name!r}{meant(name, known)}; write the file of a policy, a folder of them, module:factory, "
        f"or one of: {', '.join(known)}"
    )


def require_playable(sources: Sequence[str], task: Task) -> None:
    """Raise an ``AgentError``, before anything is run, for an agent that is named twice or is plainly not there.

    What a factory makes is seen when that agent's turn comes, so that one which fails keeps no other from being scored.
    """
    twice = next((source for source in sources if sources.count(source) > 1), None)
    if twice is not None:
        raise AgentError(f"agent {twice!r} is named twice; name each agent once")
    for source in sources if len(sources) > 1 else ():  # a single one is loaded and played at once
        if apart := runs_apart(source):
            _require_there(apart)
        else:
            load_agents(source, get_scenario(task.scenario))


def require_loadable(source: str, task: Task) -> None:
    """Raise an ``InputError`` if an agent does not load."""
    for loaded in load_agents(source, get_scenario(task.scenario)):
        with loaded:
            pass


def _load_checkpoint(path: Path, scenario: Scenario) -> LoadedAgent:
    from hhrl_agents.policies import checkpoints  # noqa: PLC0415

    agent = checkpoints.load(path)
    _require_fit(agent.metadata, scenario, path)
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    return LoadedAgent("learned", lambda: agent, digest, training_record(agent.metadata, path), path)


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
