"""One test episode, step by step: state, decisions, attention, and the rewards of both levels."""

import numpy as np
from numpy.typing import NDArray

from hhrl_agents import Agent
from hhrl_bench.analysis_attention import attend, attentive
from hhrl_bench.analysis_levels import rewards_by_level
from hhrl_bench.analysis_records import EpisodeTraceRecord, Series, decimals, outcome_name, series
from hhrl_bench.analysis_steps import Steps, record_episode
from hhrl_bench.players import OPTIONS
from hhrl_bench.tasks import Task, get_task
from hhrl_envs import get_scenario
from hhrl_envs.observation import SYMBOLS, to_si


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
