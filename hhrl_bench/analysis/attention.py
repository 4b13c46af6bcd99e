"""What an agent attends to and decides: over one test episode, step by step, and all over the (d_f, d_d) plane."""

from typing import NamedTuple

import numpy as np

from hhrl_agents import Agent
from hhrl_bench.analysis.levels import rewards_by_level
from hhrl_bench.analysis.records import (
    EpisodeTraceRecord,
    Grid,
    PlaneRecord,
    Series,
    Weights,
    decimals,
    outcome_name,
    series,
)
from hhrl_bench.analysis.steps import Steps, record_episode
from hhrl_bench.evaluation.guarded_agent import OPTIONS, GuardedAgent, attend, attentive
from hhrl_bench.schema import OptionName
from hhrl_bench.tasks.tasks import AnyTask, get_task
from hhrl_envs import Scenario, get_scenario
from hhrl_envs import observation as obs
from hhrl_envs.arrays import Floats, Floats32
from hhrl_envs.errors import require_value
from hhrl_envs.observation import SIZE, SYMBOLS, to_si
from hhrl_envs.simulation.constants import pack
from hhrl_envs.simulation.sensing import derive_states

POINTS = 41
FARTHEST_FRONT, FARTHEST_LINE = 60.0, 80.0  # m; where the axes of the plane end, unless the sensors see less far


def attention_over_episode(agent: Agent, task: AnyTask, episode: int = 0) -> EpisodeTraceRecord:
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


def _by_symbol(values: Floats32) -> dict[str, Series]:
    return {symbol: tuple(column) for symbol, column in zip(SYMBOLS, decimals(values).T.tolist(), strict=True)}


def mean_attention(agent: Agent, steps: Steps) -> dict[OptionName, Weights] | None:
    """Return the mean weights I(s, o) over the agent's steps, by selected option; None without options or attention."""
    able = attentive(agent)
    if able is None or not steps.hierarchical:
        return None
    weights = attend(able, steps.observations, steps.option).astype(np.float64)
    means = {name: weights[steps.option == o].mean(axis=0) for name, o in OPTIONS.items() if (steps.option == o).any()}
    return {name: dict(zip(SYMBOLS, mean.tolist(), strict=True)) for name, mean in means.items()}


class Speeds(NamedTuple):
    """The speeds [m/s] of ego and front vehicle that a plane holds fixed; neither of them accelerates."""

    v_e: float
    v_f: float


def typical_speeds(scenario: Scenario) -> Speeds:
    """Return the middle of the scenario's start speeds, for both vehicles."""
    low, high = scenario.road.start_speed
    return Speeds((low + high) / 2, (low + high) / 2)


def plane_states(scenario: Scenario, speeds: Speeds, d_f: Floats, d_d: Floats) -> Floats32:
    """Return the observations of vehicles without acceleration at distances [n] in metres, float32 [n, 11].

    The other elements follow from these by the environment's own Eq. (dis), without sensor noise.

    Raises:
        InputError: for speeds or distances that the scenario's sensors cannot show.
    """
    limit, sensor = scenario.road.speed_limit, scenario.sensor
    require_value(0.0 <= speeds.v_e <= limit, "v_e", speeds.v_e, f"0 to {limit:g} m/s")
    require_value(0.0 <= speeds.v_f < np.inf, "v_f", speeds.v_f, "0 m/s or more")
    wrong = d_f[~((d_f >= 0.0) & (d_f <= sensor.front_range))]
    require_value(not wrong.size, "d_f", wrong[:1], f"0 to {sensor.front_range:g} m")
    wrong = d_d[~(d_d <= sensor.line_range)]
    require_value(not wrong.size, "d_d", wrong[:1], f"at most {sensor.line_range:g} m")
    state = np.zeros((len(d_f), SIZE))
    state[:, obs.V_E], state[:, obs.V_F], state[:, obs.D_F], state[:, obs.D_D] = *speeds, d_f, d_d
    derive_states(state, pack(scenario))
    return (state * obs.SCALES).astype(np.float32)


def attention_over_plane(agent: Agent, scenario: Scenario, speeds: Speeds | None = None) -> PlaneRecord:
    """Return the greedy option and action, and the attention for every option, on a grid of (d_f, d_d) in metres.

    Args:
        agent: the agent to ask; a flat one has no options, and few have attention.
        scenario: where it drives.
        speeds: what the ego and the front vehicle drive; by default the scenario's typical ones.

    Raises:
        InputError: for speeds that cannot be, or an agent that answers nonsense.
    """
    speeds = speeds or typical_speeds(scenario)
    front = np.linspace(0.0, min(FARTHEST_FRONT, scenario.sensor.front_range), POINTS)
    line = np.linspace(0.0, min(FARTHEST_LINE, scenario.sensor.line_range), POINTS)
    d_d, d_f = (axis.ravel() for axis in np.meshgrid(line, front, indexing="ij"))
    states = plane_states(scenario, speeds, d_f, d_d)
    asked = GuardedAgent(agent, scenario.num_actions)
    asked.reset(np.ones(len(states), np.bool_))
    decision = asked.act(states)
    names = tuple(OPTIONS)
    return PlaneRecord(
        v_e=speeds.v_e,
        v_f=speeds.v_f,
        d_f=tuple(front.tolist()),
        d_d=tuple(line.tolist()),
        option=tuple(tuple(names[o] for o in row) for row in decision.option.reshape(POINTS, POINTS))
        if (decision.option >= 0).all()
        else None,
        action=tuple(map(tuple, decision.action.reshape(POINTS, POINTS).tolist())),
        attention=_attention_by_option(agent, scenario, states),
    )


def _attention_by_option(
    agent: Agent, scenario: Scenario, states: Floats32
) -> dict[OptionName, dict[str, Grid]] | None:
    able = attentive(agent)
    if able is None:
        return None
    grids: dict[OptionName, dict[str, Grid]] = {}
    for name, option in OPTIONS.items():
        if scenario.option_mask[option]:
            weights = decimals(attend(able, states, np.full(len(states), option, np.int64)))
            columns = weights.T.reshape(SIZE, POINTS, POINTS).tolist()
            grids[name] = {s: tuple(map(tuple, column)) for s, column in zip(SYMBOLS, columns, strict=True)}
    return grids
