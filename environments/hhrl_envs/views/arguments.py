"""What users hand to a view: render modes, seeds, flags, options, agents, and actions with their meaning."""

import operator
from collections.abc import Sequence
from math import nan
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from hhrl_envs.errors import InputError, require_value
from hhrl_envs.scenario.scenario import Scenario
from hhrl_envs.scenario.validation import is_integer
from hhrl_envs.sub_goals import SUB_GOALS, Option

RENDER_MODES = ("human", "rgb_array")


def as_render_mode(mode: str | None) -> str | None:
    """Return the render mode if it is one of ``RENDER_MODES`` or None, else raise an ``InputError``."""
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
    """Return the flag as a bool; raise an ``InputError`` if it is none."""
    require_value(isinstance(flag, (bool, np.bool_)), name, repr(flag), "True or False")
    return bool(flag)


def as_option(option: int | None) -> Option | None:
    """Return the option; None for None and for the -1 of a flat agent."""
    known = option is None or (is_integer(option) and -1 <= option < len(SUB_GOALS))
    names = ", ".join(f"{goal.option.value} ({goal.spelling})" for goal in SUB_GOALS)
    require_value(known, "option", repr(option), f"{names}, or None for a flat agent")
    return None if option is None or option < 0 else Option(option)


def require_horizon(scenario: Scenario, max_episode_steps: int | None) -> None:
    """Raise an ``InputError`` if a limit of Gymnasium's, -1 and None being none, would cut the scenario's episodes."""
    limit, horizon = max_episode_steps, scenario.horizon
    allowed = f"{horizon} or more, the horizon of {scenario.id!r}; hhrl_envs.register gives a scenario its own id, "
    allowed += "and replace(scenario, horizon=...) another horizon"
    require_value(limit is None or limit == -1 or limit >= horizon, "max_episode_steps", limit, allowed)


def as_autoreset(mode: AutoresetMode | str) -> AutoresetMode:
    """Return Gymnasium's auto-reset mode of a name or of itself."""
    names = [each.value for each in AutoresetMode]
    known = isinstance(mode, AutoresetMode) or mode in names
    require_value(known, "autoreset_mode", repr(mode), f"an AutoresetMode or one of {names}")
    return AutoresetMode(mode)


def as_reset_mask(options: Any, rows: int) -> NDArray[np.bool_] | None:
    """Return which rows to reset, bool [rows]: ``options["reset_mask"]``; None, for all, where there is none."""
    mask = options.get("reset_mask") if isinstance(options, dict) else None
    known = isinstance(mask, np.ndarray) and mask.dtype == np.bool_ and mask.shape == (rows,) and mask.any()
    allowed = f"a numpy array of {rows} truth values, one of them True at least"
    require_value(mask is None or bool(known), "reset_mask", repr(mask), allowed)
    return mask


def as_agent(agent: str, agents: Sequence[str]) -> str:
    """Return the name of an agent if it is one of ``agents``, else raise an ``InputError``."""
    require_value(agent in agents, "agent", repr(agent), f"one of {list(agents)}")
    return agent


def bad_agents(actions: Any, agents: Sequence[str]) -> InputError:
    """Return the error that says whose actions are missing or too many."""
    given = f"actions for {list(actions)}" if isinstance(actions, dict) else f"actions are {actions!r}"
    if not agents:
        return InputError(f"{given}, but the episode is over; call reset() first")
    return InputError(f"{given}; write a dict with one action for each of {list(agents)}")


class Levels:
    """Discrete actions: action j aims at ``scenario.vehicle.levels[j]``."""

    def __init__(self, scenario: Scenario) -> None:
        self.space = spaces.Discrete(scenario.num_actions)
        self.allowed = f"an integer from 0 to {scenario.num_actions - 1}, a level of {scenario.id!r}"
        self._levels = list(scenario.vehicle.levels)

    def acceleration(self, agent: str, action: Any) -> float:
        """Return the target acceleration in m/s^2; raises ``InputError`` for an action that is no level."""
        try:
            level = operator.index(action)
            if level >= 0 and not isinstance(action, bool):
                return self._levels[level]
        except (TypeError, IndexError):
            pass
        raise _bad_action(agent, action, self.allowed)

    def keys(self) -> dict[tuple[int, ...], int]:
        """Return which key means which action: w full throttle, s full brake, d roll on; 1, 2, ... the levels."""
        levels = self._levels
        named = {"w": len(levels) - 1, "s": 0, "d": min(range(len(levels)), key=lambda level: abs(levels[level]))}
        numbered = {str(level + 1): level for level in range(min(len(levels), 9))}
        return {(ord(key),): level for key, level in {**named, **numbered}.items()}

    def masks(self, rows: int) -> NDArray[np.bool_]:
        """Return which actions are allowed, bool [rows, num_actions]: all of them, always."""
        return np.ones((rows, len(self._levels)), np.bool_)

    def batch(self, actions: Any, rows: int) -> NDArray[np.int64]:
        """Return the actions of all rows as the simulator takes them, integers [rows]."""
        given = actions if isinstance(actions, np.ndarray) else _array(actions, rows)
        if given.shape != (rows,) or given.dtype.kind not in "iu":
            raise InputError(f"actions are {given.dtype} {given.shape}; write integers of shape ({rows},)")
        return given


class Pedals:
    """Continuous actions: a number in [-1, 1], the share of full throttle above 0 and of the full brake below."""

    def __init__(self, scenario: Scenario) -> None:
        self.space = spaces.Box(-1.0, 1.0, (1,), np.float32)
        self.allowed = "one number from -1 (full brake) to 1 (full throttle)"
        self._brake, self._throttle = -scenario.vehicle.levels[0], scenario.vehicle.levels[-1]

    def acceleration(self, agent: str, action: Any) -> float:
        """Return the target acceleration in m/s^2; raises ``InputError`` for anything but a number in [-1, 1]."""
        share = _number(action)
        if not -1.0 <= share <= 1.0:
            raise _bad_action(agent, action, self.allowed)
        return share * (self._throttle if share >= 0.0 else self._brake)

    def keys(self) -> dict[tuple[int, ...], NDArray[np.float32]]:
        """Return which key means which action: w full throttle, s full brake, d roll on."""
        return {(ord(key),): np.array([share], np.float32) for key, share in (("w", 1.0), ("s", -1.0), ("d", 0.0))}

    def masks(self, rows: int) -> NDArray[np.bool_]:
        """Raise an ``InputError``: there is nothing to mask."""
        raise InputError(f"{rows} continuous actions have no masks; write continuous_actions=False")

    def batch(self, actions: Any, rows: int) -> NDArray[np.float64]:
        """Return the target accelerations of all rows in m/s^2, float64 [rows], of shares [rows, 1]."""
        given = actions if isinstance(actions, np.ndarray) else _array(actions, rows)
        if given.shape != (rows, 1) or given.dtype.kind != "f":
            raise InputError(f"actions are {given.dtype} {given.shape}; write floats of shape ({rows}, 1)")
        shares = given[:, 0].astype(np.float64)
        outside = shares[~(np.abs(shares) <= 1.0)]
        if outside.size:
            raise InputError(f"action {outside[0]} is out of range; write {self.allowed}")
        return shares * np.where(shares >= 0.0, self._throttle, self._brake)


def driver(scenario: Scenario, continuous_actions: bool) -> Levels | Pedals:
    """Return what the actions of a view mean: `Pedals` if they are continuous, else `Levels`."""
    return (Pedals if as_flag(continuous_actions, "continuous_actions") else Levels)(scenario)


def _number(action: Any) -> float:
    """Return the action as a number; NaN if it is none."""
    try:
        given = np.asarray(action)
    except ValueError:  # lists of unequal length
        return nan
    return float(given.item()) if given.size == 1 and given.dtype.kind in "iuf" else nan


def _array(actions: Any, rows: int) -> NDArray[Any]:
    try:
        return np.asarray(actions)
    except ValueError as error:  # lists of unequal length
        raise InputError(f"actions are {actions!r}; write one for each of {rows} rows") from error


def _bad_action(agent: str, action: Any, allowed: str) -> InputError:
    return InputError(f"action of {agent!r} is {action!r}; write {allowed}")
