"""Result arrays that nobody holds any more, to be filled again: fresh pages of memory cost more than filling them."""

from sys import getrefcount
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

Number = TypeVar("Number", bound=np.generic)

_MOST = 3  # arrays kept: what a step hands out, what it replaces, and one in use elsewhere
_FREE = 3  # references to an array that is held by the list, the loop and the call alone


class Spares(Generic[Number]):
    """Hands out arrays of one shape and type, none of them while somebody holds it or a view of it."""

    def __init__(self, shape: tuple[int, ...], dtype: type[Number]) -> None:
        self._shape, self._dtype = shape, dtype
        self._arrays: list[NDArray[Number]] = []

    def take(self) -> NDArray[Number]:
        """Return an array with arbitrary contents that nobody else has."""
        for array in self._arrays:
            if getrefcount(array) == _FREE:
                return array
        fresh: NDArray[Number] = np.empty(self._shape, self._dtype)
        self._arrays = [fresh, *self._arrays[: _MOST - 1]]
        return fresh
