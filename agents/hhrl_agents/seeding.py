"""The random generators of a training seed: one for each purpose."""

from enum import IntEnum

import numpy as np

from hhrl_envs.state import State, read

_WORD = 2**64


class Purpose(IntEnum):
    """What a stream of random numbers is used for."""

    INITIALISATION = 0
    EXPLORATION = 1
    REPLAY = 2
    SHUFFLING = 3


def generator(seed: int, purpose: Purpose) -> np.random.Generator:
    """Return a PCG64 generator, a pure function of (seed, purpose)."""
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence((seed, purpose))))


def save_stream(stream: np.random.Generator) -> State:
    """Return where a generator is, uint64 [6]: both halves of PCG64's state and of its increment, its buffer."""
    state = stream.bit_generator.state
    numbers = (*divmod(state["state"]["state"], _WORD), *divmod(state["state"]["inc"], _WORD))
    return {"stream": np.array([*numbers, state["has_uint32"], state["uinteger"]], np.uint64)}


def restore_stream(stream: np.random.Generator, state: State) -> None:
    """Put a generator where `save_stream` has found it."""
    words = read(state, "stream", np.zeros(6, np.uint64)).tolist()
    high, low, inc_high, inc_low, has_uint32, uinteger = words
    stream.bit_generator.state = {
        "bit_generator": "PCG64",
        "state": {"state": high * _WORD + low, "inc": inc_high * _WORD + inc_low},
        "has_uint32": has_uint32,
        "uinteger": uinteger,
    }
