"""Agents made of functions, and what the outputs of other libraries' networks choose."""

from collections.abc import Callable
from typing import Any

import numpy as np

from hhrl_agents.agent import NO_OPTION, Agent, Decision
from hhrl_envs.arrays import Flags, Floats32, Ints
from hhrl_envs.errors import InputError

Act = Callable[[Floats32], Any]
"""Actions [B] for observations float32 [B, elements], or a pair of options and actions."""

ActWithOption = Callable[[Floats32, Ints], Ints]
"""Actions [B] for observations float32 [B, elements] and options int64 [B]."""


def from_callable(
    act: Act, act_with_option: ActWithOption | None = None, reset: Callable[[Flags], None] | None = None
) -> Agent:
    """Return the agent that a function is.

    Args:
        act: takes observations, float32 [B, elements], and returns actions, int [B], as a flat agent does, or a pair of
            options and actions.
        act_with_option: the actions that pursue given options, so that an option can be held.
        reset: hears which rows begin an episode, bool [B].
    """
    if act_with_option is None:
        return FunctionAgent(act, reset)
    return HierarchicalFunctionAgent(act, act_with_option, reset)


class FunctionAgent:
    """An agent whose ``act`` is a function.

    Attributes:
        name: what tables call it: by default as the function is called.
    """

    def __init__(self, act: Act, reset: Callable[[Flags], None] | None = None, name: str | None = None) -> None:
        self._act, self._reset = act, reset
        self.name = name or str(getattr(act, "__name__", type(act).__name__))

    def reset(self, mask: Flags) -> None:
        """Tell the function's owner which rows begin an episode; see `Agent.reset`."""
        if self._reset is not None:
            self._reset(mask)

    def act(self, observations: Floats32) -> Decision:
        """Return what the function decides, with no option (-1) if that is actions alone; see `Agent.act`."""
        return as_decision(self._act(observations))


class HierarchicalFunctionAgent(FunctionAgent):
    """An agent of two functions, the second of which acts given the option."""

    def __init__(self, act: Act, act_with_option: ActWithOption, reset: Callable[[Flags], None] | None = None) -> None:
        super().__init__(act, reset)
        self._act_with_option = act_with_option

    def act_with_option(self, observations: Floats32, option: Ints) -> Ints:
        """Return the actions given the options; see `HierarchicalAgent.act_with_option`."""
        return self._act_with_option(observations, option)


def as_decision(answer: Any) -> Decision:
    """Return a decision: a pair is options and actions, anything else the actions of a flat agent."""
    if isinstance(answer, tuple) and len(answer) == 2:
        return Decision(*map(np.asarray, answer))
    actions = np.asarray(answer)
    return Decision(np.full(actions.shape, NO_OPTION), actions)


def choices(output: Any, rows: int, count: int | None = None) -> Ints:
    """Return what an output of a network chooses for B rows, int64 [B].

    Args:
        output: values or logits, floats [B, choices], of which the first highest one is chosen, or the choices
            themselves, integers [B] or [B, 1].
        rows: B.
        count: how many choices there are, if that is known.

    Raises:
        InputError: if it is neither.
    """
    array = np.asarray(output)
    if array.dtype.kind in "iu" and array.size == rows:
        return array.reshape(rows).astype(np.int64)
    wide = array.ndim == 2 and len(array) == rows and array.shape[1] > 1
    if array.dtype.kind == "f" and wide and count in {None, array.shape[1]}:
        best: Ints = array.argmax(axis=1)
        return best
    raise InputError(
        f"the network's output has shape {array.shape} and type {array.dtype}; let it return values of shape "
        f"({rows}, {count or 'choices'}), or integers of shape ({rows},)"
    )
