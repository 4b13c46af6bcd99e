"""Global generators lent to one seed: for a library that draws from them."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import torch

from hhrl_agents.seeding import Purpose, generators

States = tuple[Any, torch.Tensor]


class GlobalStreams:
    """What one seed draws from the global generators of numpy and torch, a pure function of the seed."""

    def __init__(self, seed: int) -> None:
        drawn = int(generators([seed], Purpose.INITIALISATION)[0].integers(2**32))
        legacy = np.random.RandomState(drawn)
        self._states: States = (legacy.get_state(), torch.Generator().manual_seed(drawn).get_state())

    @contextmanager
    def lent(self) -> Iterator[None]:
        """Return a context in which the global generators go on where this seed's last draws ended.

        After it they are what they were before.
        """
        before = _states()
        _set(self._states)
        try:
            yield
        finally:
            self._states = _states()
            _set(before)


def _states() -> States:
    return np.random.get_state(), torch.get_rng_state()  # noqa: NPY002


def _set(states: States) -> None:
    np.random.set_state(states[0])  # noqa: NPY002
    torch.set_rng_state(states[1])
