"""The trained policies that come with the package, as the frozen part of another method."""

from pathlib import Path

from torch import Tensor

from hhrl_agents import checkpoints
from hhrl_agents.methods import Method
from hhrl_agents.networks import FFV
from hhrl_envs.errors import InputError

SHIPPED = Path(__file__).parent / "trained"
SEED = 0


def frozen_parameters(method: Method) -> dict[str, Tensor]:
    """Return what the method uses without learning it: its FFV policy's parameters, behind `ffv.`; empty without one.

    They are those of training seed 0, whatever seeds are trained with them.

    Raises:
        InputError: if no such policy comes with the package, or one of another config.
    """
    if method.ffv is None:
        return {}
    path = SHIPPED / method.ffv.id / f"seed-{SEED}.safetensors"
    trained = checkpoints.load(path)
    if trained.method != method.ffv:
        raise InputError(
            f"method {method.id!r} follows with {method.ffv.id!r}, but {path} has another config; train that again"
        )
    return {FFV + name: value for name, value in trained.parameters.items()}
