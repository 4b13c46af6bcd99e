"""PettingZoo's names for ``stop-line-v0``: ``parallel_env`` is the native view, ``env`` and ``raw_env`` are AEC."""

from typing import Any

from pettingzoo import AECEnv
from pettingzoo.utils import wrappers
from pettingzoo.utils.conversions import parallel_to_aec

from hhrl_envs.parallel_env import StopLineParallelEnv


def parallel_env(render_mode: str | None = None) -> StopLineParallelEnv:
    """Return the parallel PettingZoo environment."""
    return StopLineParallelEnv("stop-line-v0", render_mode)


def raw_env(render_mode: str | None = None) -> AECEnv[Any, Any, Any]:
    """Return the AEC environment without wrappers."""
    aec: AECEnv[Any, Any, Any] = parallel_to_aec(parallel_env(render_mode))
    return aec


def env(render_mode: str | None = None) -> AECEnv[Any, Any, Any]:
    """Return the AEC environment with PettingZoo's order-enforcing wrapper."""
    return wrappers.OrderEnforcingWrapper(raw_env(render_mode))
