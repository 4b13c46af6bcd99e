"""Agents as the evaluation plays them: every decision checked, failures said in one line, an option held on request."""

import contextlib
import os
import sys
import sysconfig
import traceback
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

import hhrl_agents
import hhrl_bench
import hhrl_envs
from hhrl_agents import Agent, Decision, HierarchicalAgent
from hhrl_bench.errors import AgentError
from hhrl_bench.schema import OptionName
from hhrl_envs import Option

IntArray = NDArray[np.int64]
Result = TypeVar("Result")

_LIBRARIES = (sysconfig.get_path(name) for name in ("stdlib", "purelib", "platlib"))
_OURS = (str(Path(str(package.__file__)).parent) for package in (hhrl_bench, hhrl_agents, hhrl_envs))
_NOT_THE_USERS = ("<string>", "<frozen", *(folder + os.sep for folder in (*_LIBRARIES, *_OURS)))

OPTIONS: Mapping[OptionName, Option] = {"stop": Option.SSL, "follow": Option.FFV}


def option_name(spelling: str | None) -> OptionName | None:
    """Return the option's name, given that or the paper's, in any case; None for None.

    Raises:
        AgentError: if it is no option's.
    """
    names = {word: name for name, option in OPTIONS.items() for word in (name, option.name.lower())}
    if spelling is not None and spelling.lower() not in names:
        known = ", ".join(f"{name} or {option.name}" for name, option in OPTIONS.items())
        raise AgentError(f"unknown option {spelling!r}; write one of: {known}")
    return None if spelling is None else names[spelling.lower()]


class Player(NamedTuple):
    """An agent to be played by an evaluation, with ``num_actions`` levels; ``option`` holds the option fixed."""

    agent: Agent
    num_actions: int
    option: Option | None = None

    def reset(self, mask: NDArray[np.bool_]) -> None:
        """Return nothing; tell the agent which rows, bool [B], start an episode."""
        guarded(lambda: self.agent.reset(mask.copy()), "reset")

    def act(self, observations: NDArray[np.float32]) -> Decision:
        """Return the checked decisions int64 [B] for observations float32 [B, 11].

        Raises:
            AgentError: if the agent fails, or answers anything but B options and B actions of the scenario.
        """
        rows = len(observations)
        answer = guarded(lambda: self._ask(observations.copy()), "act")
        if not isinstance(answer, tuple) or len(answer) != 2:
            raise AgentError(f"the agent's act returned {type(answer).__name__}; return Decision(option, action)")
        option = _checked(answer[0], "options", rows, -1, len(Option) - 1)
        return Decision(option, _checked(answer[1], "actions", rows, 0, self.num_actions - 1))

    def _ask(self, observations: NDArray[np.float32]) -> object:
        if self.option is None:
            return self.agent.act(observations)
        if not isinstance(self.agent, HierarchicalAgent):
            raise AgentError("a flat agent has no option to hold; leave out --option")
        held = np.full(len(observations), self.option, np.int64)
        return held, self.agent.act_with_option(observations, held)


def guarded(call: Callable[[], Result], what: str) -> Result:
    """Return what ``call`` returns; what it prints goes to stderr, for stdout belongs to results.

    Raises:
        AgentError: in place of whatever else it raises, naming the error and the line it comes from.
    """
    try:
        with contextlib.redirect_stdout(sys.stderr):
            return call()
    except AgentError:
        raise
    except (Exception, SystemExit) as error:
        raise AgentError(f"the agent's {what} raised {type(error).__name__}: {error} ({_blamed(error)})") from error


def _blamed(error: BaseException) -> str:
    """Return the file and line to look at: the innermost of the user's, else the innermost of all."""
    frames = traceback.extract_tb(error.__traceback__)
    users = [frame for frame in frames if not frame.filename.startswith(_NOT_THE_USERS)]
    blamed = (users or frames)[-1]
    return f"{Path(blamed.filename).name}, line {blamed.lineno}"


def _checked(values: object, what: str, rows: int, low: int, high: int) -> IntArray:
    try:
        array = np.asarray(values)
    except (ValueError, TypeError) as error:
        raise AgentError(f"the agent's {what} are no array; return integers of shape ({rows},)") from error
    if array.shape != (rows,) or array.dtype.kind not in "iu":
        raise AgentError(
            f"the agent's {what} have shape {array.shape} and type {array.dtype}; return integers of shape ({rows},)"
        )
    if array.min() < low or array.max() > high:
        raise AgentError(f"the agent's {what} go from {array.min()} to {array.max()}; return {low} to {high}")
    return array.astype(np.int64)
