import subprocess
import sys
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from hhrl_agents import METHODS, RULES, Agent, Decision, HierarchicalAgent
from hhrl_agents.policies.learned_agent import HierarchicalLearnedAgent
from hhrl_agents.training.learner import make_learner
from hhrl_envs import SCENARIOS, Option, Scenario, Simulator, get_scenario
from support.configs import with_values

NAMES = [*RULES, *METHODS]
SMALL: dict[str, Any] = {"n_envs": 4, "warmup": 40, "replay_capacity": 40, "rollout_steps": 16, "batch_size": 32}
"""What an untrained policy does not depend on."""

EVERYWHERE = pytest.mark.parametrize("scenario", SCENARIOS.values(), ids=SCENARIOS)


@cache
def agent_of(name: str, scenario: Scenario) -> Agent:
    """The rule agent, or an untrained agent of the method."""
    if name in RULES:
        return RULES[name](scenario)
    method = with_values(METHODS[name], SMALL)
    worlds = np.arange(method.config.n_envs, dtype=np.uint64)
    return make_learner(method, scenario, 0, worlds).policy()


@cache
def observations_of(scenario: Scenario, rows: int, steps: int = 30) -> NDArray[np.float32]:
    simulator = Simulator(scenario, rows)
    simulator.reset(np.arange(rows) + 50)
    for step in range(steps):
        simulator.step(np.full(rows, step % scenario.num_actions))
        simulator.reset_done()
    return simulator.observations.copy()


def afresh(agent: Agent, observations: NDArray[np.float32]) -> Decision:
    """What the agent decides where all episodes begin."""
    agent.reset(np.ones(len(observations), np.bool_))
    return agent.act(observations)


@EVERYWHERE
@pytest.mark.parametrize("rows", [1, 7])
@pytest.mark.parametrize("name", NAMES)
def test_decisions_are_valid(name: str, rows: int, scenario: Scenario) -> None:
    agent, observations = agent_of(name, scenario), observations_of(scenario, rows)
    assert isinstance(agent, Agent)
    option, action = afresh(agent, observations)
    for part in (option, action):
        assert part.shape == (rows,)
        assert part.dtype == np.int64
    assert ((action >= 0) & (action < scenario.num_actions)).all()
    if isinstance(agent, HierarchicalAgent):
        assert np.array(scenario.option_mask)[option].all()
    else:
        assert (option == -1).all()


@pytest.mark.parametrize("name", NAMES)
def test_decisions_repeat_and_do_not_depend_on_the_order_of_rows(name: str) -> None:
    scenario = get_scenario("stop-line-v0")
    agent, observations = agent_of(name, scenario), observations_of(scenario, 7)
    before = observations.copy()
    first, second, turned = (afresh(agent, rows) for rows in (observations, observations, observations[::-1]))
    np.testing.assert_array_equal(observations, before)
    for ours, again, back in zip(first, second, turned, strict=True):
        np.testing.assert_array_equal(ours, again)
        np.testing.assert_array_equal(ours, back[::-1])


@pytest.mark.parametrize("name", NAMES)
def test_only_hierarchical_agents_take_an_option(name: str) -> None:
    scenario = get_scenario("stop-line-v0")
    agent, observations = agent_of(name, scenario), observations_of(scenario, 7)
    assert isinstance(agent, HierarchicalAgent) == (name in RULES or METHODS[name].hierarchical)
    if isinstance(agent, HierarchicalAgent):
        for option in Option:
            action = agent.act_with_option(observations, np.full(7, option))
            assert action.shape == (7,)
            assert ((action >= 0) & (action < scenario.num_actions)).all()


@pytest.mark.parametrize("name", [name for name, m in METHODS.items() if m.hierarchical and "action" in m.levels])
def test_learned_agents_show_their_attention(name: str) -> None:
    scenario = get_scenario("stop-line-v0")
    agent, observations = agent_of(name, scenario), observations_of(scenario, 7)
    assert isinstance(agent, HierarchicalLearnedAgent)
    weights = agent.attention(observations, np.zeros(7, np.int64))
    np.testing.assert_allclose(weights.sum(axis=1), 1.0, rtol=1e-5)
    assert (weights.std() > 1e-3) == METHODS[name].attention


def test_agents_need_no_torch_until_they_learn() -> None:
    code = (
        "import sys; sys.modules['torch'] = None; import hhrl_agents, hhrl_envs;"
        "scenario = hhrl_envs.get_scenario('stop-line-v0');"
        "[make(scenario) for make in hhrl_agents.RULES.values()]; print(len(hhrl_agents.METHODS))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert int(done.stdout) == len(METHODS)
