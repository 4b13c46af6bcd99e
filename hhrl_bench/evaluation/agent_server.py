"""What runs in the process of a user's agent: it makes the agent, asks it what the harness asks, and answers."""

import json
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO

from numpy.typing import NDArray

from hhrl_agents import HierarchicalAgent
from hhrl_bench.evaluation.factories import make_agent
from hhrl_bench.evaluation.guarded_agent import GuardedAgent, attend, attentive, checked_actions, guarded
from hhrl_bench.extensions import load_extensions
from hhrl_bench.isolation import frames
from hhrl_bench.isolation.confinement import confine
from hhrl_bench.isolation.supervision import supervise
from hhrl_bench.tracebacks import show_traceback
from hhrl_envs import scenario_from_json
from hhrl_envs.arrays import Flags, Floats32, Ints
from hhrl_envs.errors import InputError

Method = Callable[..., Sequence[NDArray[Any]]]


def main() -> None:
    """Make the agent that the first request names and answer for it until the harness closes the pipe."""
    requests, answers = _take_pipes()
    order = json.loads(frames.read_text(requests))
    supervise()  # from here on in one thread, which is all that can be confined
    confine(Path(order["scratch"]), order["memory"])
    _Server(requests, answers).serve(order)


def _take_pipes() -> tuple[BinaryIO, BinaryIO]:
    """Return the pipes of requests and answers; what is printed from now on goes to stderr."""
    requests, answers = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    with Path(os.devnull).open() as nothing:
        os.dup2(nothing.fileno(), 0)
    os.dup2(2, 1)
    sys.stdout = sys.stderr
    return requests, answers


class _Server:
    """The agent's methods by their names, and the pipes."""

    def __init__(self, requests: BinaryIO, answers: BinaryIO) -> None:
        self._requests, self._answers = requests, answers
        self._own = os.getpid()
        self._methods: Mapping[str, Method] = {}

    def serve(self, order: Mapping[str, Any]) -> None:
        """Answer the order, and then one call after the other if there is an agent."""
        self._answer(lambda: self._make(order))
        try:
            while self._methods:
                self._answer_call()
        except EOFError:
            return

    def _make(self, order: Mapping[str, Any]) -> bytes:
        self._methods = _make_methods(order)
        return bytes(name in self._methods for name in frames.ABILITIES)

    def _answer_call(self) -> None:
        number, rows, width = frames.REQUEST.unpack(frames.read_exactly(self._requests, frames.REQUEST.size))
        name, call = frames.numbered(number)
        data = frames.read_exactly(self._requests, frames.size(call.takes, rows, width))

        def make() -> bytes:
            arrays = frames.unpack(call.takes, data, rows, width)
            return frames.pack(call.gives, self._methods[name](*arrays), rows, width)

        self._answer(make)

    def _answer(self, make: Callable[[], bytes]) -> None:
        try:
            answer = frames.answer(make())
        except BaseException as error:  # noqa: BLE001 - the agent may raise what it likes, or have changed what is here
            show_traceback(error)
            raised = f"the agent's process raised {type(error).__name__}: {error}"
            answer = frames.failure(str(error) if isinstance(error, InputError) else raised)
        if os.getpid() != self._own:  # a copy, which the agent has forked and not ended
            os._exit(0)
        self._answers.write(answer)
        self._answers.flush()


def _make_methods(order: Mapping[str, Any]) -> Mapping[str, Method]:
    """Return the methods of the agent that an order names, each of which takes and gives what its call says."""
    load_extensions()
    os.chdir(order["scratch"])
    scenario = scenario_from_json(order["scenario"])
    agent = make_agent(order["source"], scenario, Path(order["module_folder"]))
    asked = GuardedAgent(agent, scenario.num_actions)
    methods: dict[str, Method] = {"reset": partial(_reset, asked), "act": asked.act}
    if isinstance(agent, HierarchicalAgent):
        methods["act_with_option"] = partial(_act_with_option, agent, scenario.num_actions)
    if (able := attentive(agent)) is not None:
        methods["attention"] = lambda observations, option: (attend(able, observations, option),)
    return methods


def _reset(agent: GuardedAgent, mask: Flags) -> Sequence[NDArray[Any]]:
    agent.reset(mask)
    return ()


def _act_with_option(
    agent: HierarchicalAgent, num_actions: int, observations: Floats32, option: Ints
) -> Sequence[NDArray[Any]]:
    answer = guarded(lambda: agent.act_with_option(observations, option), "act")
    return (checked_actions(answer, len(observations), num_actions),)
