from dataclasses import replace
from typing import Any, Literal

import numpy as np
import pytest

from hhrl_agents import METHODS
from hhrl_agents.agent import ACTION, OPTION
from hhrl_agents.methods.method import Method
from hhrl_agents.training.environments import discounts, learning_rewards
from hhrl_envs import Outcome, Simulator, get_scenario
from hhrl_envs.simulation.rewards import FAILURE, SUCCESS, TIME, TIMEOUT, UNSAFE, UNSMOOTH
from support.driving import careful_actions

MAIN = get_scenario("stop-line-v0")
SHORT = replace(MAIN, id="short", horizon=90)
ROWS = 200


Timeout = Literal["truncation", "terminal"]


def with_timeout(name: str, timeout: Timeout) -> Method:
    method = METHODS[name]
    return replace(method, config=replace(method.config, timeout=timeout))


@pytest.fixture(scope="module")
def simulator() -> Simulator:
    """A batch at a step in which episodes run, fail, succeed and time out."""
    made = Simulator(SHORT, ROWS)
    made.reset(np.arange(ROWS))
    rng = np.random.default_rng(0)
    reckless = rng.random(ROWS) < 0.4
    for _ in range(SHORT.horizon):
        made.reset_done()
        made.step(np.where(reckless, MAIN.num_actions - 1, careful_actions(made)))
    assert (made.outcomes == Outcome.TIMEOUT).any()
    return made


@pytest.mark.parametrize("timeout", ["truncation", "terminal"])
def test_without_hybrid_reward_both_levels_get_the_task_s(simulator: Simulator, timeout: Timeout) -> None:
    method = with_timeout("hrl-0", timeout)
    rewards = learning_rewards(method, simulator.of_agent(0), np.zeros(ROWS, np.int64)) / method.config.reward_scale
    left_out = simulator.terms[:, TIMEOUT] if timeout == "truncation" else 0.0
    for level in (OPTION, ACTION):
        np.testing.assert_allclose(rewards[:, level], simulator.rewards - left_out, atol=1e-9)


@pytest.mark.parametrize("timeout", ["truncation", "terminal"])
def test_hybrid_rewards_are_the_selected_option_s_and_add_up(simulator: Simulator, timeout: Timeout) -> None:
    method = with_timeout("hybrid-hrl", timeout)
    options = np.random.default_rng(1).integers(0, 2, ROWS)
    rewards = learning_rewards(method, simulator.of_agent(0), options) / method.config.reward_scale
    left_out = simulator.terms[:, TIMEOUT] if timeout == "truncation" else np.zeros(ROWS)
    for row in range(ROWS):
        assert rewards[row, OPTION] == pytest.approx(simulator.reward_option[row, options[row]] - left_out[row])
        assert rewards[row, ACTION] == pytest.approx(simulator.reward_action[row, options[row]] - left_out[row])
    common = simulator.terms[:, [TIME, TIMEOUT, SUCCESS]].sum(axis=1) - left_out
    np.testing.assert_allclose(rewards.sum(axis=1) - common, simulator.rewards - left_out, atol=1e-9)


@pytest.mark.parametrize("weight", [0.0, 0.3])
@pytest.mark.parametrize(
    ("name", "values", "levels"),
    [
        ("hrl-0", {}, (OPTION, ACTION)),
        ("ddqn", {"timeout": "terminal"}, (OPTION, ACTION)),
        ("hybrid-hrl", {}, (ACTION,)),
        ("hybrid-hrl", {"timeout": "terminal"}, (ACTION,)),
        ("hybrid-hrl", {"credit": "algorithm-2"}, (ACTION,)),
    ],
)
def test_unsmoothness_counts_for_its_weight_where_it_is_charged(
    simulator: Simulator, name: str, values: dict[str, Any], levels: tuple[int, ...], weight: float
) -> None:
    method = replace(METHODS[name], config=replace(METHODS[name].config, **values))
    smooth = replace(method, config=replace(method.config, jerk_weight=weight))
    options, unsmooth = np.random.default_rng(1).integers(0, 2, ROWS), simulator.terms[:, UNSMOOTH]
    assert unsmooth.any()
    full, weighed = (
        learning_rewards(m, simulator.of_agent(0), options) / m.config.reward_scale for m in (method, smooth)
    )
    for level in (OPTION, ACTION):
        left_out = (1.0 - weight) * unsmooth if level in levels else 0.0
        np.testing.assert_allclose(weighed[:, level], full[:, level] - left_out, atol=1e-9)


def test_only_running_and_truncated_rows_bootstrap(simulator: Simulator) -> None:
    gamma = METHODS["ddqn"].config.gamma
    truncated = discounts(with_timeout("ddqn", "truncation"), simulator.of_agent(0))
    terminal = discounts(with_timeout("ddqn", "terminal"), simulator.of_agent(0))
    for row, outcome in enumerate(simulator.outcomes):
        assert truncated[row] == (gamma if outcome in {Outcome.RUNNING, Outcome.TIMEOUT} else 0.0)
        assert terminal[row] == (gamma if outcome == Outcome.RUNNING else 0.0)


@pytest.mark.parametrize("weight", [1.0, 0.3])
def test_algorithm_2_blames_the_option_for_the_selected_sub_goal(weight: float) -> None:
    """r^option = sr + unsafe and failure of the selected one; r^action = sr + jerk + those of the other one."""
    method = with_timeout("hybrid-hrl", "terminal")
    method = replace(method, config=replace(method.config, credit="algorithm-2", jerk_weight=weight))
    played, rng, rows = Simulator(MAIN, ROWS), np.random.default_rng(1), np.arange(ROWS)
    played.reset(rows)
    seen = np.zeros(SUCCESS + 1, np.bool_)
    for _ in range(250):
        played.reset_done()
        played.step(np.where(rows % 2, MAIN.num_actions - 1, careful_actions(played)))
        options, terms = rng.integers(0, 2, ROWS), played.terms
        rewards = learning_rewards(method, played.of_agent(0), options) / method.config.reward_scale
        common = terms[:, [TIME, TIMEOUT, SUCCESS]].sum(axis=1)
        faults = (terms[:, UNSAFE] + terms[:, FAILURE]).T
        np.testing.assert_allclose(rewards[:, OPTION], common + faults[options, rows], atol=1e-9)
        expected = common + weight * terms[:, UNSMOOTH] + faults[1 - options, rows]
        np.testing.assert_allclose(rewards[:, ACTION], expected, atol=1e-9)
        seen |= terms.any(axis=0)
    assert seen[[UNSMOOTH, *UNSAFE, *FAILURE]].all()
