"""Driving environments for hierarchical reinforcement learning: stop at a stop-line behind traffic."""

import sys
from types import ModuleType

from hhrl_envs import observation
from hhrl_envs.errors import InputError, UnknownScenarioError
from hhrl_envs.scenario.files import read_scenario, scenario_from_json, scenario_to_json
from hhrl_envs.scenario.profiles import ProfileFamily
from hhrl_envs.scenario.registry import SCENARIOS, get_scenario
from hhrl_envs.scenario.scenario import (
    Adversary,
    Band,
    Goal,
    Reward,
    Road,
    Scenario,
    Signal,
    Slippery,
    Traffic,
    Vehicle,
)
from hhrl_envs.scenario.sensors import Ghosts, Sensor
from hhrl_envs.simulation.simulator import Simulator
from hhrl_envs.sub_goals import SUB_GOALS, Option, Outcome, SubGoal
from hhrl_envs.views.infos import NumericInfos
from hhrl_envs.views.triad import register, triad
from hhrl_envs.worlds import WORLDS

__all__ = [
    "SCENARIOS",
    "SUB_GOALS",
    "Adversary",
    "Band",
    "Ghosts",
    "Goal",
    "InputError",
    "NumericInfos",
    "Option",
    "Outcome",
    "ProfileFamily",
    "Reward",
    "Road",
    "Scenario",
    "Sensor",
    "Signal",
    "Simulator",
    "Slippery",
    "SubGoal",
    "Traffic",
    "UnknownScenarioError",
    "Vehicle",
    "get_scenario",
    "observation",
    "read_scenario",
    "register",
    "scenario_from_json",
    "scenario_to_json",
    "triad",
]

# for ``import hhrl_envs.stop_line_v0``
sys.modules.update({f"{__name__}.{name}": world for name, world in WORLDS.items()})


def __getattr__(name: str) -> ModuleType:
    """Return the module of a world: ``from hhrl_envs import stop_line_v0``."""
    if name in WORLDS:
        return WORLDS[name]
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
