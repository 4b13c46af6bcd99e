"""The types of arrays that the three packages hand to each other."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Floats32 = NDArray[np.float32]
Ints = NDArray[np.int64]
Keys = NDArray[np.uint64]
Codes = NDArray[np.int8]
Flags = NDArray[np.bool_]
