"""Per-episode records of an evaluation: the numbers every metric is computed from."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class EpisodeRecords:
    """What N episodes came to; every field is an array [N], episode i being the same world for every agent.

    Attributes:
        seed: world seed, uint64.
        outcome: how the episode ended (:class:`hhrl_envs.Outcome`), int8.
        steps: environment steps, int32.
        return_task: undiscounted sum of r^task, float64.
        return_option: undiscounted sum of r^option for the selected options; NaN for flat agents, float64.
        return_action: undiscounted sum of r^action for the selected options; NaN for flat agents, float64.
        unsmooth: steps with too large a jerk, int32.
        unsafe: sum of the unsafe penalties of both sub-goals, positive, float64.
    """

    seed: NDArray[np.uint64]
    outcome: NDArray[np.int8]
    steps: NDArray[np.int32]
    return_task: NDArray[np.float64]
    return_option: NDArray[np.float64]
    return_action: NDArray[np.float64]
    unsmooth: NDArray[np.int32]
    unsafe: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.seed)

    def digest(self) -> str:
        """Return the sha256, in hex, of every field's name and little-endian bytes: equal for equal episodes."""
        sha = hashlib.sha256()
        for field in fields(self):
            array = getattr(self, field.name)
            sha.update(f"{field.name}:{array.dtype.name}:{len(self)};".encode())
            sha.update(array.astype(array.dtype.newbyteorder("<")).tobytes())
        return sha.hexdigest()


def join(parts: Sequence[EpisodeRecords], length: int) -> EpisodeRecords:
    """Return the first ``length`` episodes of several records, one after the other."""
    names = [field.name for field in fields(EpisodeRecords)]
    return EpisodeRecords(**{name: np.concatenate([getattr(part, name) for part in parts])[:length] for name in names})
