"""Agents as a rollout asks them: every decision checked, failures said in one line, an option held on request."""

import contextlib
import os
import sys
import sysconfig
import traceback
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple, Protocol, TypeVar, runtime_checkable

import numpy as np

import hhrl_agents
import hhrl_bench
import hhrl_envs
from hhrl_agents import Agent, ClairvoyantAgent, Decision, HierarchicalAgent
from hhrl_agents.agent import NO_OPTION
from hhrl_bench.errors import AgentError
from hhrl_bench.schema import OptionName
from hhrl_envs import SUB_GOALS, Option, Simulator
from hhrl_envs.arrays import Flags, Floats32, Ints
from hhrl_envs.observation import SIZE

Result = TypeVar("Result")

_LIBRARIES = (sysconfig.get_path(name) for name in ("stdlib", "purelib", "platlib"))
_OURS = (str(Path(str(package.__file__)).parent) for package in (hhrl_bench, hhrl_agents, hhrl_envs))
_NOT_THE_USERS = ("<string>", "<frozen", *(folder + os.sep for folder in (*_LIBRARIES, *_OURS)))

OPTIONS: Mapping[OptionName, Option] = {goal.name: goal.option for goal in SUB_GOALS}
"""The options by the names of their sub-goals, in their order."""

_OPTION_WORDS = {NO_OPTION: "flat", **{int(goal.option): goal.spelling for goal in SUB_GOALS}}


def option_name(spelling: str | None) -> OptionName | None:
    """Return the option's name, given that or the paper's, in any case; None for None.

    Raises:
        AgentError: if it is no option's.
    """
    names = {word: goal.name for goal in SUB_GOALS for word in (goal.name, goal.spelling.lower())}
    if spelling is not None and spelling.lower() not in names:
        known = ", ".join(f"{goal.name} or {goal.spelling}" for goal in SUB_GOALS)
        raise AgentError(f"unknown option {spelling!r}; write one of: {known}")
    return None if spelling is None else names[spelling.lower()]


class GuardedAgent(NamedTuple):
    """An agent whose decisions are checked, with ``num_actions`` levels; ``option`` holds its option fixed."""

    agent: Agent
    num_actions: int
    option: Option | None = None

    def reset(self, mask: Flags) -> None:
        """Tell the agent which rows, bool [B], start an episode."""
        guarded(lambda: self.agent.reset(mask.copy()), "reset")

    def foresee(self, simulator: Simulator) -> None:
        """Show the worlds at the start of their episodes to an agent that is clairvoyant.

        Raises:
            InputError: if it cannot foresee these.
        """
        if isinstance(self.agent, ClairvoyantAgent):
            self.agent.foresee(simulator)

    def act(self, observations: Floats32) -> Decision:
        """Return the checked decisions int64 [B] for observations float32 [B, 11].

        Raises:
            AgentError: if the agent fails, or answers anything but B options and B actions of the scenario.
        """
        rows = len(observations)
        answer = guarded(lambda: self._ask(observations.copy()), "act")
        if not isinstance(answer, tuple) and hasattr(answer, "__array__"):
            answer = (np.full(rows, NO_OPTION), answer)  # actions alone are a flat agent's
        if not isinstance(answer, tuple) or len(answer) != 2:
            raise AgentError(
                f"the agent's act returned {type(answer).__name__}; return Decision(option, action), or an array of "
                "actions"
            )
        action = checked_actions(answer[1], rows, self.num_actions)  # first: a flat agent has said nothing else
        return Decision(checked_options(answer[0], rows), action)

    def _ask(self, observations: Floats32) -> object:
        if self.option is None:
            return self.agent.act(observations)
        if not isinstance(self.agent, HierarchicalAgent):
            raise AgentError("a flat agent has no option to hold; leave out --option")
        held = np.full(len(observations), self.option, np.int64)
        return held, self.agent.act_with_option(observations, held)


@runtime_checkable
class AttentiveAgent(Protocol):
    """An agent whose action level weighs the state elements given the option."""

    def attention(self, observations: Floats32, option: Ints) -> Floats32:
        """Return the weights I(s, o), float32 [B, 11], for ``observations``, float32 [B, 11], and ``option`` [B]."""


def attentive(agent: Agent) -> AttentiveAgent | None:
    """Return the agent if it learned an attention, else None; methods without one would answer equal weights."""
    method = getattr(agent, "method", None)
    learned = method is None or bool(getattr(method, "attention", True))
    return agent if learned and isinstance(agent, AttentiveAgent) else None


def attend(agent: AttentiveAgent, observations: Floats32, option: Ints) -> Floats32:
    """Return the weights I(s, o), float32 [B, 11], each row summing to 1.

    Raises:
        AgentError: if the agent fails, or answers anything but B rows of 11 numbers.
    """
    weights = np.asarray(guarded(lambda: agent.attention(observations.copy(), option.copy()), "attention"))
    if weights.shape != (len(observations), SIZE) or weights.dtype.kind != "f" or not np.isfinite(weights).all():
        raise AgentError(
            f"the agent's attention has shape {weights.shape} and type {weights.dtype}; "
            f"return finite float32 of shape ({len(observations)}, {SIZE})"
        )
    return weights.astype(np.float32)


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


def checked_options(values: object, rows: int) -> Ints:
    """Return an agent's options as int64 [rows], -1 where it is flat; raise an ``AgentError`` for anything else."""
    *others, last = (f"{number} ({meaning})" for number, meaning in _OPTION_WORDS.items())
    return _checked(values, "options", rows, range(NO_OPTION, len(Option)), f"{', '.join(others)} or {last}")


def checked_actions(values: object, rows: int, num_actions: int) -> Ints:
    """Return an agent's actions as int64 [rows]; raise an ``AgentError`` for anything else than indices of levels."""
    write = f"indices of scenario.vehicle.levels, 0 to {num_actions - 1}"
    return _checked(values, "actions", rows, range(num_actions), write)


def _checked(values: object, what: str, rows: int, allowed: range, write: str) -> Ints:
    try:
        array = np.asarray(values)
    except (ValueError, TypeError, RuntimeError) as error:  # the last one from a tensor on another device
        raise AgentError(f"the agent's {what} are no array; return integers of shape ({rows},), {write}") from error
    if array.shape != (rows,) or array.dtype.kind not in "iu":
        raise AgentError(
            f"the agent's {what} have shape {array.shape} and type {array.dtype}; "
            f"return integers of shape ({rows},), {write}"
        )
    if array.min() < allowed[0] or array.max() > allowed[-1]:
        raise AgentError(f"the agent's {what} go from {array.min()} to {array.max()}; return {write}")
    return array.astype(np.int64)
