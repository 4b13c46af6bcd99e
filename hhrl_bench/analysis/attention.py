"""One test episode, step by step: state, decisions, attention, and the rewards of both levels."""

from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from hhrl_agents import Agent
from hhrl_bench.analysis.levels import rewards_by_level
from hhrl_bench.analysis.records import EpisodeTraceRecord, Series, decimals, outcome_name, series
from hhrl_bench.analysis.steps import Steps, record_episode
from hhrl_bench.errors import AgentError
from hhrl_bench.evaluation.guarded_agent import OPTIONS, guarded
from hhrl_bench.tasks.tasks import Task, get_task
from hhrl_envs import get_scenario
from hhrl_envs.observation import SIZE, SYMBOLS, to_si


def attention_over_episode(agent: Agent, task: str | Task, episode: int = 0) -> EpisodeTraceRecord:
    """Return test episode ``episode``, which is the evaluation's, step by step, with the attention if there is one.

    Raises:
        InputError: for an unknown task, an episode outside the test set, or an agent that answers nonsense.
    """
    task = get_task(task)
    steps = record_episode(agent, task, episode)
    rewards = rewards_by_level(steps)
    names = tuple(OPTIONS)
    return EpisodeTraceRecord(
        number=episode,
        seed=int(steps.seeds[0]),
        outcome=outcome_name(steps.outcomes[0]),
        time=tuple((np.arange(len(steps.episode)) * get_scenario(task.scenario).dt).round(9).tolist()),
        state=_by_symbol(to_si(steps.observations)),
        option=tuple(names[option] for option in steps.option) if steps.hierarchical else None,
        action=tuple(steps.action.tolist()),
        attention=_attention(agent, steps),
        reward=series(rewards),
        cumulative=series({level: np.cumsum(values) for level, values in rewards.items()}),
    )


def _attention(agent: Agent, steps: Steps) -> dict[str, Series] | None:
    able = attentive(agent)
    if able is None or not steps.hierarchical:
        return None
    return _by_symbol(attend(able, steps.observations, steps.option))


def _by_symbol(values: NDArray[np.float32]) -> dict[str, Series]:
    return {symbol: tuple(column) for symbol, column in zip(SYMBOLS, decimals(values).T.tolist(), strict=True)}


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
