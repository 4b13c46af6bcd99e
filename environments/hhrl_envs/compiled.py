"""The one way in which this package compiles its kernels, with the types that it uses."""

from collections.abc import Callable
from typing import TypeVar, cast

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Floats32 = NDArray[np.float32]
Ints = NDArray[np.int64]
Keys = NDArray[np.uint64]
Codes = NDArray[np.int8]

F = TypeVar("F", bound=Callable[..., object])


def kernel(function: F) -> F:
    """Return ``function`` compiled: cached on disk, without the interpreter lock, with exact IEEE arithmetic.

    ``error_model="numpy"`` lets a division by zero give inf instead of an exception, without which no loop with a division
    would vectorise. ``fastmath`` stays off: the same bits on every machine, in every batch.
    """
    return cast(F, njit(cache=True, nogil=True, error_model="numpy")(function))
