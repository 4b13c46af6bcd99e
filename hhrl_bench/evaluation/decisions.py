"""Traces: every decision in episodes, from which the simulator comes to the same episodes again, bit for bit."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hhrl_agents import Agent, Decision
from hhrl_agents.training.drivers import Drivers
from hhrl_envs.arrays import Codes, Flags, Floats32, Ints


class Trace(NamedTuple):
    """What was decided in N episodes, one after the other, T steps in all.

    Attributes:
        steps: how long each episode is, int32 [N].
        options: the selected options of the vehicles that the agent drives, -1 of a flat agent, int8 [T, slots].
        actions: the levels of all vehicles that are driven, int8 [T, A].
    """

    steps: NDArray[np.int32]
    options: Codes
    actions: Codes


class Recorder:
    """The decisions in a batch of B rows, step by step."""

    def __init__(self) -> None:
        self._options: list[Codes] = []
        self._actions: list[Codes] = []

    def add(self, options: Ints, actions: Ints) -> None:
        """Add the options [B slots] and the actions [B] or [B, A] of a step."""
        rows = len(actions)
        self._options.append(options.astype(np.int8).reshape(rows, -1))
        self._actions.append(actions.astype(np.int8).reshape(rows, -1))

    def trace(self, steps: NDArray[np.int32]) -> Trace:
        """Return the trace of the rows, whose episodes have this many steps, int32 [B]."""
        lasted = np.arange(len(self._actions)) < steps[:, None]
        options, actions = (np.stack(parts, axis=1)[lasted] for parts in (self._options, self._actions))
        return Trace(steps, options, actions)


def join(parts: Sequence[Trace], length: int) -> Trace:
    """Return the first ``length`` episodes of several traces, one after the other."""
    steps, options, actions = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    end = steps[:length].sum()
    return Trace(steps[:length], options[:end], actions[:end])


def episodes_of(trace: Trace, part: slice) -> Trace:
    """Return the episodes of a trace from the first to before the last of a part."""
    begin, end = int(trace.steps[: part.start].sum()), int(trace.steps[: part.stop].sum())
    return Trace(trace.steps[part], trace.options[begin:end], trace.actions[begin:end])


class Recording:
    """An agent that decides for N rows what a trace says, whatever it sees; after the end of an episode, nothing."""

    def __init__(self, steps: NDArray[np.int32], options: Codes, actions: Codes) -> None:
        """Options and actions are [T, slots], see :class:`Trace`; the rows of an episode lie side by side."""
        self._steps, self._slots = steps, options.shape[1]
        self._first = np.cumsum(steps) - steps
        self._options, self._actions = options, actions
        self._step = 0

    def reset(self, mask: Flags) -> None:
        """Start all episodes anew."""
        self._step = 0

    def act(self, observations: Floats32) -> Decision:
        """Return the decisions int64 [N slots] of the next step."""
        last = np.minimum(self._step, self._steps - 1)
        self._step += 1
        place = self._first + last
        options, actions = self._options[place], self._actions[place]
        return Decision(options.ravel().astype(np.int64), actions.ravel().astype(np.int64))


def recording(trace: Trace, slots: Sequence[int]) -> Agent:
    """Return the agent that drives the vehicles ``slots`` as in a trace."""
    return Recording(trace.steps, trace.options, trace.actions[:, list(slots)])


def recordings(trace: Trace, slots: Sequence[int]) -> tuple[Agent, Drivers]:
    """Return the agent that drives the vehicles ``slots`` as in a trace, and who drives the others."""
    own = recording(trace, slots)
    others: Mapping[int, Agent] = {
        slot: Recording(trace.steps, np.full_like(trace.actions[:, [slot]], -1), trace.actions[:, [slot]])
        for slot in range(trace.actions.shape[1])
        if slot not in slots
    }
    return own, Drivers(tuple(slots), others)
