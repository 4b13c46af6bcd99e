"""What an agent's action means: an acceleration that its actuator aims at."""

from math import nan
from operator import index
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from hhrl_envs.errors import InputError
from hhrl_envs.scenario.scenario import Scenario
from hhrl_envs.views.arguments import as_flag


class Levels:
    """Discrete actions: action j aims at ``scenario.vehicle.levels[j]``."""

    def __init__(self, scenario: Scenario) -> None:
        self.space = spaces.Discrete(scenario.num_actions)
        self.allowed = f"an integer from 0 to {scenario.num_actions - 1}, a level of {scenario.id!r}"
        self._levels = list(scenario.vehicle.levels)

    def acceleration(self, agent: str, action: Any) -> float:
        """Return the target acceleration in m/s^2; raises ``InputError`` for an action that is no level."""
        try:
            level = index(action)
            if level >= 0 and not isinstance(action, bool):
                return self._levels[level]
        except (TypeError, IndexError):
            pass
        raise _bad_action(agent, action, self.allowed)

    def batch(self, actions: Any, rows: int) -> NDArray[np.int64]:
        """Return the actions of all rows as the simulator takes them, integers [rows]."""
        given = _array(actions, rows)
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

    def batch(self, actions: Any, rows: int) -> NDArray[np.float64]:
        """Return the target accelerations of all rows in m/s^2, float64 [rows], of shares [rows, 1]."""
        given = _array(actions, rows)
        if given.shape != (rows, 1) or given.dtype.kind != "f":
            raise InputError(f"actions are {given.dtype} {given.shape}; write floats of shape ({rows}, 1)")
        shares = given[:, 0].astype(np.float64)
        outside = shares[~(np.abs(shares) <= 1.0)]
        if outside.size:
            raise InputError(f"action {outside[0]} is out of range; write {self.allowed}")
        return shares * np.where(shares >= 0.0, self._throttle, self._brake)


def driver(scenario: Scenario, continuous_actions: bool) -> Levels | Pedals:
    """Return what the actions of a view mean."""
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
