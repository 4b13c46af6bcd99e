"""The state of something that can be saved and go on later: named arrays, nothing else."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hhrl_envs.errors import InputError

State = dict[str, NDArray[Any]]
"""name -> array, at least one-dimensional, which later steps do not change."""


def count(value: int) -> NDArray[np.int64]:
    """Return a whole number as an array of a state, int64 [1]."""
    return np.array([value], np.int64)


def read_count(state: Mapping[str, NDArray[Any]], name: str) -> int:
    """Return the whole number that `count` has put into a state."""
    return int(read(state, name, np.zeros(1, np.int64))[0])


def read(state: Mapping[str, NDArray[Any]], name: str, like: NDArray[Any]) -> NDArray[Any]:
    """Return the array of a name, which must have the shape and type of ``like``.

    Raises:
        InputError: if there is none or it has not.
    """
    if not isinstance(state, Mapping):
        raise InputError(f"the state is a {type(state).__name__}; write what state() has returned")
    found = state.get(name)
    if found is None or found.shape != like.shape or found.dtype != like.dtype:
        what = "nothing" if found is None else f"{found.dtype} {found.shape}"
        raise InputError(f"the state holds {what} as {name!r}; it must be {like.dtype} {like.shape}")
    return found
