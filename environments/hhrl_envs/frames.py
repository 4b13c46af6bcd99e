"""The arrays that a step hands out; those that nobody holds any more are filled again.

Fresh pages of memory cost more than filling them, and to make the views of a step anew costs as much as to check that
nobody has them any more.
"""

from sys import getrefcount
from typing import Any, NamedTuple

import numpy as np

from hhrl_envs import layout as at
from hhrl_envs import observation
from hhrl_envs.compiled import Codes, Flags, Floats, Floats32

_MOST = 3  # frames kept: what a step hands out, what it replaces, and one in use elsewhere


class Frame(NamedTuple):
    """What the agents of all B rows get from a step; what is to be kept are its arrays, not the frame.

    Attributes:
        all_observations, all_results, all_codes: what the kernel fills, float32 [11, A, B], float64 [RESULTS_SIZE, A,
            B] and int8 [3, A, B]; see ``advancing``. All else is views of the ego's part of them.
        observations: scaled observations, float32 [B, 11]; see ``hhrl_envs.observation``.
        rewards: r^task, float64 [B].
        reward_option, reward_action: r^option and r^action if option k is the selected one, float64 [B, 2].
        outcomes: ``Outcome`` codes, int8 [B].
        terminations, truncations: whether the step ended the episode, and how, bool [B].
    """

    all_observations: Floats32
    all_results: Floats
    all_codes: Codes
    observations: Floats32
    rewards: Floats
    reward_option: Floats
    reward_action: Floats
    outcomes: Codes
    terminations: Flags
    truncations: Flags

    def __reduce__(self) -> Any:
        """Return how to copy or unpickle a frame, so that its views are views again."""
        return frame_of, self[:3]


class Frames:
    """Hands out frames for ``agents`` agents in ``rows`` rows, none while somebody holds one of its arrays."""

    def __init__(self, agents: int, rows: int) -> None:
        self._shape = agents, rows
        self._frames: list[tuple[Frame, int]] = []

    def take(self) -> Frame:
        """Return a frame with arbitrary contents that nobody else has."""
        for place, (frame, free) in enumerate(self._frames):
            if sum(map(getrefcount, frame)) == free:
                self._frames.insert(1, self._frames.pop(place))  # two go to and fro: the last but one comes first
                return frame
        observations = np.empty((observation.SIZE, *self._shape), np.float32)
        results, codes = np.empty((at.RESULTS_SIZE, *self._shape)), np.empty((3, *self._shape), np.int8)
        fresh = frame_of(observations, results, codes)
        del observations, results, codes
        self._frames = [*self._frames[: _MOST - 1], (fresh, sum(map(getrefcount, fresh)))]
        return fresh


def frame_of(observations: Floats32, results: Floats, codes: Codes) -> Frame:
    """Return the frame of what the kernel fills."""
    ego, flags = results[:, 0], codes[:, 0].view(np.bool_)
    views = (observations[:, 0].T, ego[0], ego[1:3].T, ego[3:5].T, codes[0, 0], flags[1], flags[2])
    return Frame(observations, results, codes, *views)
