"""The random generators of a seed: one for each purpose, whatever seeds are trained beside it."""

from collections.abc import Sequence
from enum import IntEnum

import numpy as np

from hhrl_envs.arrays import Floats
from hhrl_envs.state import State, read

_WORD = 2**64


class Purpose(IntEnum):
    """What a stream of random numbers is used for."""

    INITIALISATION = 0
    EXPLORATION = 1
    REPLAY = 2
    SHUFFLING = 3


def generators(seeds: Sequence[int], purpose: Purpose) -> list[np.random.Generator]:
    """Return one PCG64 generator for each seed, a pure function of (seed, purpose)."""
    return [np.random.Generator(np.random.PCG64(np.random.SeedSequence((seed, purpose)))) for seed in seeds]


def uniforms(streams: Sequence[np.random.Generator], *shape: int) -> Floats:
    """Return numbers uniform in [0, 1), float64 [E, *shape], row e drawn from stream e alone."""
    drawn = np.empty((len(streams), *shape))
    for row, stream in zip(drawn, streams, strict=True):
        stream.random(out=row)
    return drawn


def save_streams(streams: Sequence[np.random.Generator]) -> State:
    """Return where the generators are, uint64 [E, 6]: both halves of PCG64's state and of its increment, its buffer."""
    return {"streams": np.array([_words(stream) for stream in streams], np.uint64)}


def restore_streams(streams: Sequence[np.random.Generator], state: State) -> None:
    """Put the generators where `save_streams` has found them."""
    for stream, words in zip(streams, read(state, "streams", np.zeros((len(streams), 6), np.uint64)), strict=True):
        high, low, inc_high, inc_low, has_uint32, uinteger = words.tolist()
        stream.bit_generator.state = {
            "bit_generator": "PCG64",
            "state": {"state": high * _WORD + low, "inc": inc_high * _WORD + inc_low},
            "has_uint32": has_uint32,
            "uinteger": uinteger,
        }


def _words(stream: np.random.Generator) -> tuple[int, ...]:
    state = stream.bit_generator.state
    numbers = (*divmod(state["state"]["state"], _WORD), *divmod(state["state"]["inc"], _WORD))
    return (*numbers, state["has_uint32"], state["uinteger"])
