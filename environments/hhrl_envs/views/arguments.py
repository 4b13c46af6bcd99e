"""TODO."""

import operator
from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.utils import seeding
from numpy.typing import NDArray

from hhrl_envs.errors import InputError, require_value
from hhrl_envs.scenario.validation import is_integer
from hhrl_envs.sub_goals import Option

RENDER_MODES = ("human", "rgb_array")


def as_render_mode(mode: str | None) -> str | None:
    """Return the render mode."""
    require_value(mode in (None, *RENDER_MODES), "render_mode", repr(mode), "None, 'human' or 'rgb_array'")
    return mode


def as_seed(seed: int | None) -> int:
    """Return the seed, an integer in [0, 2^64); a fresh one where it is None."""
    if seed is None:
        return int(seeding.np_random()[1] % 2**63)
    known = is_integer(seed) and 0 <= seed < 2**64
    require_value(known, "seed", repr(seed), "an integer from 0 to 2^64 - 1, or None for a fresh one")
    return operator.index(seed)


def as_seeds(seed: int | Sequence[int] | None, rows: int) -> NDArray[np.uint64]:
    """Return a seed for each row, uint64 [rows]: ``seed + i``, or the given ones."""
    given: Any = seed
    if isinstance(given, (list, tuple)) or (isinstance(given, np.ndarray) and given.ndim == 1):
        require_value(len(given) == rows, "seed", f"a list of {len(given)}", f"one integer for each of {rows} rows")
        return np.array([as_seed(one) for one in given], np.uint64)
    known = given is None or (is_integer(given) and 0 <= given <= 2**64 - rows)
    allowed = f"an integer from 0 to 2^64 - {rows}, a list with one for each of {rows} rows, or None for fresh ones"
    require_value(known, "seed", repr(given), allowed)
    return np.uint64(as_seed(given)) + np.arange(rows, dtype=np.uint64)


def as_flag(flag: bool, name: str) -> bool:
    """Return whether something is wanted."""
    require_value(isinstance(flag, (bool, np.bool_)), name, repr(flag), "True or False")
    return bool(flag)


def as_option(option: int | None) -> Option | None:
    """Return the option; None for None and for the -1 of a flat agent."""
    known = option is None or (is_integer(option) and -1 <= option < len(Option))
    names = ", ".join(f"{one.value} ({one.name})" for one in Option)
    require_value(known, "option", repr(option), f"{names}, or None for a flat agent")
    return None if option is None or option < 0 else Option(option)


def as_agent(agent: str, agents: Sequence[str]) -> str:
    """Return the name of an agent."""
    require_value(agent in agents, "agent", repr(agent), f"one of {list(agents)}")
    return agent


def bad_agents(actions: Any, agents: Sequence[str]) -> InputError:
    """Return the error that says whose actions are missing or too many."""
    given = f"actions for {list(actions)}" if isinstance(actions, dict) else f"actions are {actions!r}"
    if not agents:
        return InputError(f"{given}, but the episode is over; call reset() first")
    return InputError(f"{given}; write a dict with one action for each of {list(agents)}")
