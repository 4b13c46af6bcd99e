"""The learner that a method asks for."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import torch

from hhrl_agents.algorithms.double_dqn import Learner
from hhrl_agents.algorithms.pqn import PQNLearner
from hhrl_agents.methods.method import Method
from hhrl_agents.training.drivers import EGO_ALONE, Drivers
from hhrl_agents.training.learner import TrainableStack
from hhrl_agents.training.start import NOTHING, Start
from hhrl_envs import Scenario
from hhrl_envs.errors import InputError, require, require_value


def make_learner(
    method: Method,
    scenario: Scenario,
    seeds: Sequence[int],
    world_seeds: npt.NDArray[np.uint64],
    device: str = "cpu",
    drivers: Drivers = EGO_ALONE,
    start: Start = NOTHING,
) -> TrainableStack:
    """Return the learner of the method's algorithm; see `Learner` for the arguments.

    Raises:
        MissingExtraError: if the algorithm is a library's that is not installed.
        InputError: if torch has no such device, the algorithm does not use it or cannot train such vehicles or from
            such a start, or the start does not fit.
    """
    require_device(device)
    if method.algorithm == "double-dqn":
        return Learner(method, scenario, seeds, world_seeds, device, drivers, start)
    alone, plain = drivers == EGO_ALONE, start is NOTHING
    require_value(alone, "method", repr(method.id), "one that learns by Double DQN, to drive other than the ego")
    require_value(plain, "start", "a start from other parameters", f"none: {method.algorithm} begins from nothing")
    if method.algorithm == "ppo":
        require_value(device == "cpu", "device", repr(device), "cpu: PPO's small networks gain nothing from another")
        require("stable_baselines3", "sb3")
        from hhrl_agents.algorithms.ppo import PPOLearner  # noqa: PLC0415

        return PPOLearner(method, scenario, seeds, world_seeds)
    return PQNLearner(method, scenario, seeds, world_seeds, device)


def require_device(device: str) -> None:
    """Return nothing; try that torch can compute on the device.

    Raises:
        InputError: if it cannot.
    """
    try:
        torch.zeros(1, device=device).cpu()
    except (RuntimeError, AssertionError) as error:
        raise InputError(
            f"torch cannot compute on device {device!r}; write cpu, or cuda where there is a GPU"
        ) from error
