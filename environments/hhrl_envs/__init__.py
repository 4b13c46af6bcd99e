"""Driving environments for hierarchical reinforcement learning: stop at a stop-line behind traffic."""

from hhrl_envs import gym_registration, observation
from hhrl_envs.errors import InputError, UnknownScenarioError
from hhrl_envs.goals import Goal
from hhrl_envs.options import Option
from hhrl_envs.outcomes import Outcome
from hhrl_envs.profiles import ProfileFamily
from hhrl_envs.registry import SCENARIOS, get_scenario
from hhrl_envs.scenario import Adversary, Band, Reward, Road, Scenario, Sensor, Signal, Traffic, Vehicle
from hhrl_envs.simulator import Simulator
from hhrl_envs.triads import triad

gym_registration.register_all()

__all__ = [
    "SCENARIOS",
    "Adversary",
    "Band",
    "Goal",
    "InputError",
    "Option",
    "Outcome",
    "ProfileFamily",
    "Reward",
    "Road",
    "Scenario",
    "Sensor",
    "Signal",
    "Simulator",
    "Traffic",
    "UnknownScenarioError",
    "Vehicle",
    "get_scenario",
    "observation",
    "triad",
]
