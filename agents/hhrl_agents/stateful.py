"""The state of what consists of parts: every part owns its state, and the whole's is all of theirs."""

from collections.abc import Mapping
from typing import Protocol, runtime_checkable

from hhrl_envs.state import State


@runtime_checkable
class Stateful(Protocol):
    """A part that can be saved and go on later, bit for bit."""

    def state(self) -> State:
        """Return all that the part remembers."""

    def restore(self, state: State) -> None:
        """Take up what `state` has returned for a part made with the same arguments."""


def gather(parts: Mapping[str, Stateful]) -> State:
    """Return the states of all parts in one, each name after its part's and a dot."""
    return prefixed({part: stateful.state() for part, stateful in parts.items()})


def scatter(parts: Mapping[str, Stateful], state: State) -> None:
    """Restore every part from what `gather` has returned."""
    for part, stateful in parts.items():
        stateful.restore(below(state, part))


def prefixed(states: Mapping[str, State]) -> State:
    """Return the states in one, each name after its key and a dot."""
    return {f"{part}.{name}": array for part, state in states.items() for name, array in state.items()}


def below(state: State, part: str) -> State:
    """Return what stands in a state after `part` and a dot, without them."""
    return {name.removeprefix(f"{part}."): array for name, array in state.items() if name.startswith(f"{part}.")}
