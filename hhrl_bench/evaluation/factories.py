"""Users' own agents: what ``module:factory`` names, imported and called, and files with a policy of another library."""

import inspect
import os
import sys
from collections.abc import Callable
from importlib.machinery import PathFinder
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

from hhrl_agents import Agent
from hhrl_agents.adapters.files import ENDINGS, read_agent
from hhrl_bench.errors import AgentError
from hhrl_bench.evaluation.guarded_agent import guarded
from hhrl_bench.extensions import import_here
from hhrl_envs import Scenario

_GIVEN = {1: "the scenario", 2: "the scenario and the training seed"}
_HINT = "write module:factory, the module as in an import statement; it is looked for in the current folder"


TRUST = "HHRL_TRUST"
"""The environment variable that, if it is 1, lets code run that is in the file of a policy."""


def make_agent(source: str, scenario: Scenario, folder: Path) -> Agent:
    """Return the agent that ``module:factory`` makes, or the one in a file of another library, with one torch thread.

    Raises:
        InputError: in one line, if there is none.
    """
    path = Path(source)
    if path.suffix not in ENDINGS:
        return call_factory(source, scenario, folder)
    if path.suffix == ".zip" and find_spec("torch"):
        import torch  # noqa: PLC0415

        torch.set_num_threads(1)
    return read_agent(path, scenario.num_actions, trust=os.environ.get(TRUST) == "1")


def call_factory(name: str, scenario: Scenario, folder: Path) -> Agent:
    """Return the agent that ``module:factory`` makes of the scenario; the module is looked for in ``folder`` too.

    That of ``module:factory@SEED`` is made of the scenario and the training seed.

    Raises:
        AgentError: in one line, if there is no such factory, or it fails or returns no agent.
    """
    module, _, rest = name.partition(":")
    factory, _, seed = rest.partition("@")
    given = (scenario, int(seed)) if seed else (scenario,)
    make = getattr(_import(module, folder), factory, None)
    if not callable(make):
        raise AgentError(f"module {module!r} has no callable {factory!r}; write module:factory")
    _require_arity(make, name, given)
    agent = guarded(lambda: make(*given), f"factory {name}, called with {_GIVEN[len(given)]},")
    if not isinstance(agent, Agent):
        other = ", or from_callable of the function" if callable(agent) else ""
        returned = f"{name} returned {type(agent).__name__}"
        raise AgentError(f"{returned}; return an agent, with reset(mask) and act(observations){other}")
    return agent


def require_module(name: str) -> None:
    """Raise an ``AgentError`` if there is no such module as ``module:factory`` names, without running any code."""
    module, _, factory = name.partition(":")
    if module.endswith(".py"):
        raise AgentError(f"{name!r} names a file; write the module, as in {Path(module).stem}:{factory}")
    top = module.partition(".")[0]
    if not top.isidentifier() or not _is_there(top):
        raise AgentError(f"cannot import {module!r}: ModuleNotFoundError: No module named {top!r}; {_HINT}")


def _is_there(module: str) -> bool:
    try:
        return (PathFinder.find_spec(module, [str(Path.cwd()), *sys.path]) or find_spec(module)) is not None
    except (ImportError, ValueError):  # a module that cannot be found by its name
        return False


def _require_arity(make: Callable[..., object], name: str, given: tuple[object, ...]) -> None:
    try:
        inspect.signature(make).bind(*given)
    except ValueError:  # it does not say what it takes
        return
    except TypeError as error:
        raise AgentError(
            f"factory {name}{_place(make)} cannot be called with {_GIVEN[len(given)]}: {error}; let it take "
            f"{_GIVEN[len(given)]}{' alone' if len(given) == 1 else ''}"
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
