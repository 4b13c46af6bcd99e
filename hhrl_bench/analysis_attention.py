"""The attention I(s, o) of agents that have one."""

from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from hhrl_agents import Agent
from hhrl_bench.errors import AgentError
from hhrl_bench.players import guarded
from hhrl_envs.observation import SIZE

Float32Array = NDArray[np.float32]


@runtime_checkable
class AttentiveAgent(Protocol):
    """An agent whose action level weighs the state elements given the option."""

    def attention(self, observations: Float32Array, option: NDArray[np.int64]) -> Float32Array:
        """Return the weights I(s, o), float32 [B, 11], for ``observations``, float32 [B, 11], and ``option`` [B]."""


def attentive(agent: Agent) -> AttentiveAgent | None:
    """Return the agent if it learned an attention, else None; methods without one would answer equal weights."""
    method = getattr(agent, "method", None)
    learned = method is None or bool(getattr(method, "attention", True))
    return agent if learned and isinstance(agent, AttentiveAgent) else None


def attend(agent: AttentiveAgent, observations: Float32Array, option: NDArray[np.int64]) -> Float32Array:
    """Return the weights I(s, o), float32 [B, 11], each row summing to 1.

    Raises:
        AgentError: if the agent fails, or answers anything but B rows of 11 numbers.
    """
    weights = np.asarray(guarded(lambda: agent.attention(observations.copy(), option.copy()), "attention"))
    if weights.shape != (len(observations), SIZE) or weights.dtype.kind != "f" or not np.isfinite(weights).all():
        raise AgentError(
            f"the agent's attention has shape {weights.shape} and type {weights.dtype}; "
            f"return finite float32 of shape ({len(observations)}, {SIZE})"
        )
    return weights.astype(np.float32)
