"""Users' factories: what ``module:factory`` names, imported and called with the scenario."""

import inspect
import sys
from collections.abc import Callable
from importlib.machinery import PathFinder
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

from hhrl_agents import Agent
from hhrl_bench.errors import AgentError
from hhrl_bench.evaluation.guarded_agent import guarded
from hhrl_bench.extensions import import_here
from hhrl_envs import Scenario

_HINT = "write module:factory, the module as in an import statement; it is looked for in the current folder"


def call_factory(name: str, scenario: Scenario, folder: Path) -> Agent:
    """Return the agent that ``module:factory`` makes; the module is looked for in ``folder`` too.

    Raises:
        AgentError: in one line, if there is no such factory, or it fails or returns no agent.
    """
    module, _, factory = name.partition(":")
    make = getattr(_import(module, folder), factory, None)
    if not callable(make):
        raise AgentError(f"module {module!r} has no callable {factory!r}; write module:factory")
    _require_arity(make, name, scenario)
    agent = guarded(lambda: make(scenario), f"factory {name}, called with the scenario,")
    if not isinstance(agent, Agent):
        raise AgentError(f"{name} returned {type(agent).__name__}; return an agent: reset(mask) and act(observations)")
    return agent


def require_module(name: str) -> None:
    """Raise an ``AgentError`` if there is no such module as ``module:factory`` names, without running any code."""
    module = name.partition(":")[0]
    top = module.partition(".")[0]
    if not top.isidentifier() or not _is_there(top):
        raise AgentError(f"cannot import {module!r}: ModuleNotFoundError: No module named {top!r}; {_HINT}")


def _is_there(module: str) -> bool:
    try:
        return (PathFinder.find_spec(module, [str(Path.cwd()), *sys.path]) or find_spec(module)) is not None
    except (ImportError, ValueError):  # a module that cannot be found by its name
        return False


def _require_arity(make: Callable[..., object], name: str, scenario: Scenario) -> None:
    try:
        inspect.signature(make).bind(scenario)
    except ValueError:  # it does not say what it takes
        return
    except TypeError as error:
        raise AgentError(
            f"factory {name}{_place(make)} cannot be called with the scenario: {error}; let it take the scenario alone"
        ) from error


def _place(make: Callable[..., object]) -> str:
    try:
        return f" ({Path(inspect.getfile(make)).name}, line {inspect.getsourcelines(make)[1]})"
    except (TypeError, OSError):  # neither a function nor a class, or without its source
        return ""


def _import(module: str, folder: Path) -> ModuleType:
    try:
        return import_here(module, folder)
    except (Exception, SystemExit) as error:
        raise AgentError(f"cannot import {module!r}: {type(error).__name__}: {error}; {_HINT}") from error
