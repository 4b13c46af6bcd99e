"""An analysis says what the evaluation counts, what the simulator shows, and what the agent answers."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from hhrl_agents import RULES, Agent, Decision
from hhrl_bench import evaluate, load_agent
from hhrl_bench.analysis.attention import (
    Speeds,
    attention_over_episode,
    attention_over_plane,
    mean_attention,
    plane_states,
)
from hhrl_bench.analysis.levels import level_rewards, option_usage
from hhrl_bench.analysis.steps import MAX_EPISODES, Steps, record_episode, record_steps
from hhrl_bench.errors import AgentError, SeedError
from hhrl_envs import InputError, Outcome, Simulator, get_scenario
from hhrl_envs.observation import A_F, D_D, D_F, SIZE, SYMBOLS, to_si

TASK = "stop-line-paper-v0"
SCENARIO = get_scenario(TASK)
EPISODES = 30


def rule(name: str) -> Agent:
    return RULES[name](SCENARIO)


class Attentive:
    """An agent that stops, and whose attention is whatever it is told to answer."""

    def __init__(self, answer: Any, method: object = None) -> None:
        self.answer, self.method = answer, method

    def reset(self, mask: NDArray[np.bool_]) -> None:
        pass

    def act(self, observations: NDArray[np.float32]) -> Decision:
        return Decision(np.zeros(len(observations), np.int64), np.zeros(len(observations), np.int64))

    def attention(self, observations: NDArray[np.float32], option: NDArray[np.int64]) -> Any:
        return self.answer(observations, option)


def equal(_: NDArray[np.float32], option: NDArray[np.int64]) -> NDArray[np.float32]:
    return np.full((len(option), SIZE), 1 / SIZE, np.float32)


@pytest.fixture(scope="module")
def learned() -> Agent:
    return load_agent("hybrid-hrl", TASK)


@pytest.mark.parametrize("name", ["hybrid-hrl", "ddqn", "rule-4"])
def test_sums_of_the_steps_are_the_evaluations_digit_for_digit(name: str) -> None:
    agent = load_agent(name, TASK)
    steps, records = record_steps(agent, TASK, EPISODES), evaluate(agent, TASK, EPISODES)
    assert steps.hierarchical == (name != "ddqn")
    assert steps.seeds.tolist() == records.seed.tolist()
    assert steps.outcomes.tolist() == records.outcome.tolist()
    assert np.bincount(steps.episode).tolist() == records.steps.tolist()
    np.testing.assert_array_equal(steps.sums(steps.reward_task), records.return_task)
    np.testing.assert_array_equal(steps.sums(steps.reward_option), records.return_option)
    np.testing.assert_array_equal(steps.sums(steps.reward_action), records.return_action)


def test_steps_of_a_later_batch_are_the_evaluations() -> None:
    records, steps = evaluate(rule("rule-3"), TASK, 502), record_steps(rule("rule-3"), TASK, 502)
    np.testing.assert_array_equal(steps.sums(steps.reward_action), records.return_action)
    single = record_episode(rule("rule-3"), TASK, 501)
    np.testing.assert_array_equal(single.observations, steps.observations[steps.episode == 501])
    assert single.outcomes.tolist() == [records.outcome[501]]


@pytest.mark.parametrize("episode", [0, 3])
def test_episode_is_the_evaluated_one_and_its_attention_the_agents(learned: Any, episode: int) -> None:
    records, trace = evaluate(learned, TASK, 4), attention_over_episode(learned, TASK, episode)
    assert (trace.seed, len(trace.time)) == (records.seed[episode], records.steps[episode])
    assert trace.outcome == Outcome(records.outcome[episode]).name.lower()
    assert trace.cumulative["option"][-1] == records.return_option[episode]
    assert trace.cumulative["action"][-1] == records.return_action[episode]
    assert trace.attention is not None
    assert trace.option is not None
    weights = np.array([trace.attention[symbol] for symbol in SYMBOLS]).T
    np.testing.assert_allclose(weights.sum(axis=1), 1.0, atol=1e-5)
    steps = record_episode(learned, TASK, episode)
    np.testing.assert_array_equal(weights.astype(np.float32), learned.attention(steps.observations, steps.option))
    state = np.array([trace.state[symbol] for symbol in SYMBOLS], np.float32).T
    np.testing.assert_array_equal(state, to_si(steps.observations))
    assert [("stop", "follow").index(name) for name in trace.option] == steps.option.tolist()


def test_what_an_agent_lacks_is_missing_and_the_rest_is_there() -> None:
    flat, ruled = load_agent("ddqn", TASK), rule("rule-4")
    trace, plane, steps = attention_over_episode(flat, TASK), attention_over_plane(flat, SCENARIO), None
    assert (trace.option, trace.attention, plane.option, plane.attention) == (None, None, None, None)
    assert list(trace.cumulative) == ["task"]
    steps = record_steps(flat, TASK, 5)
    assert option_usage(steps, SCENARIO) is None
    assert list(level_rewards(steps).overall.levels) == ["task"]
    assert mean_attention(ruled, record_steps(ruled, TASK, 5)) is None
    assert attention_over_episode(ruled, TASK).attention is None


def test_plane_states_are_the_simulators() -> None:
    simulator = Simulator(SCENARIO, 200)
    simulator.reset(np.arange(200))
    compared = 0
    for row, seen in enumerate(simulator.observations):
        ego, front = simulator.vehicles(row)[:2]
        d_f, d_d = front[0] - SCENARIO.vehicle.length - ego[0], -ego[0]
        if np.isnan(d_f) or to_si(seen)[A_F] != 0.0:
            continue
        states = plane_states(SCENARIO, Speeds(ego[1], front[1]), np.array([d_f]), np.array([d_d]))
        np.testing.assert_array_equal(states[0], seen)
        compared += 1
    assert compared > 100


def test_plane_of_rule_4_is_its_rule() -> None:
    plane = attention_over_plane(rule("rule-4"), SCENARIO, Speeds(6.0, 6.0))
    d_d, d_f = np.meshgrid(plane.d_d, plane.d_f, indexing="ij")
    follow = d_d > d_f - SCENARIO.reward.safe_gap  # equal speeds: d_fs is d_0
    assert (np.array(plane.option) == np.where(follow, "follow", "stop")).all()
    assert 0.1 < follow.mean() < 0.9


def test_plane_holds_what_the_agent_answers(learned: Any) -> None:
    plane = attention_over_plane(learned, SCENARIO, Speeds(5.0, 3.0))
    states = plane_states(SCENARIO, Speeds(5.0, 3.0), np.full(41, plane.d_f[7]), np.array(plane.d_d))
    decision = learned.act(states)
    assert plane.option is not None
    assert plane.attention is not None
    assert [row[7] for row in plane.option] == [("stop", "follow")[option] for option in decision.option]
    assert [row[7] for row in plane.action] == decision.action.tolist()
    for option, name in enumerate(plane.attention):
        grids = np.array([plane.attention[name][symbol] for symbol in SYMBOLS])
        np.testing.assert_allclose(grids.sum(axis=0), 1.0, atol=1e-5)
        wanted = learned.attention(states, np.full(41, option))
        np.testing.assert_allclose(grids[:, :, 7].T, wanted, atol=1e-6)


@pytest.mark.parametrize(
    ("speeds", "d_f", "d_d", "said"),
    [
        ((-1.0, 0.0), 5.0, 5.0, "v_e is -1.0; write 0 to 12.5 m/s"),
        ((1.0, np.nan), 5.0, 5.0, "v_f is nan; write 0 m/s or more"),
        ((1.0, 1.0), 101.0, 5.0, r"d_f is \[101.\]; write 0 to 100 m"),
        ((1.0, 1.0), 5.0, 200.0, r"d_d is \[200.\]; write at most 100 m"),
    ],
)
def test_states_that_no_sensor_shows_are_refused(
    speeds: tuple[float, float], d_f: float, d_d: float, said: str
) -> None:
    with pytest.raises(InputError, match=said):
        plane_states(SCENARIO, Speeds(*speeds), np.array([d_f]), np.array([d_d]))


@pytest.mark.parametrize(("name", "only"), [("rule-1", "follow"), ("rule-2", "stop")])
def test_rules_that_never_change_the_option_use_one(name: str, only: str) -> None:
    steps = record_steps(rule(name), TASK, EPISODES)
    usage = option_usage(steps, SCENARIO)
    assert usage is not None
    for row in (usage.overall, *usage.by_outcome.values()):
        assert row.switches == 0.0
        assert row.share == {"stop": float(only == "stop"), "follow": float(only == "follow")}
    assert sum(row.episodes for row in usage.by_outcome.values()) == EPISODES
    for bins in (usage.by_d_d, usage.by_d_f):
        assert sum(one.steps for one in bins) == len(steps.episode)
        assert {one.share[only] for one in bins if one.share} == {1.0}


@pytest.fixture
def story() -> Steps:
    """Two episodes of three and two steps, at distances and with options that the tests know."""
    seen = np.zeros((5, SIZE), np.float32)
    seen[:, D_D] = np.array([39.0, 10.0, 9.0, 20.0, 9.5]) / 64
    seen[:, D_F] = np.array([100.0, 5.0, 5.0, 15.0, 99.0]) / 64
    nothing = np.zeros(5)
    return Steps(
        episode=np.array([0, 0, 0, 1, 1]),
        observations=seen,
        option=np.array([1, 0, 1, 0, 0]),
        action=np.zeros(5, np.int64),
        terms=np.zeros((5, 8)),
        reward_task=nothing,
        reward_option=nothing,
        reward_action=nothing,
        seeds=np.arange(2, dtype=np.uint64),
        outcomes=np.array([Outcome.SUCCESS, Outcome.COLLISION], np.int8),
    )


def test_option_usage_counts_shares_switches_and_places(story: Steps) -> None:
    usage = option_usage(story, SCENARIO)
    assert usage is not None
    assert usage.overall.share == {"stop": 0.6, "follow": 0.4}
    assert usage.overall.switches == 1.0
    assert (usage.by_outcome["success"].switches, usage.by_outcome["collision"].switches) == (2.0, 0.0)
    assert usage.by_outcome["collision"].share == {"stop": 1.0, "follow": 0.0}
    filled = {one.low: (one.high, one.steps, one.share and one.share["stop"]) for one in usage.by_d_d if one.steps}
    assert filled == {0.0: (10.0, 2, 0.5), 10.0: (20.0, 1, 1.0), 20.0: (30.0, 1, 1.0), 30.0: (40.0, 1, 0.0)}
    filled = {one.low: (one.high, one.steps, one.share and one.share["stop"]) for one in usage.by_d_f if one.steps}
    assert filled == {0.0: (10.0, 2, 0.5), 10.0: (20.0, 1, 1.0), 90.0: (100.0, 1, 1.0), 100.0: (None, 1, 0.0)}


def test_terms_of_each_level_sum_to_its_reward_and_both_levels_to_r_task(learned: Agent) -> None:
    steps = record_steps(learned, TASK, EPISODES)
    rewards = level_rewards(steps)
    total, terms = rewards.by_episode.total, rewards.by_episode.terms
    for level, values in total.items():
        np.testing.assert_allclose(np.sum([*terms[level].values()], axis=0), values, atol=1e-9)
        assert rewards.overall.levels[level].total == pytest.approx(np.mean(values))
        running, means = np.array(rewards.by_step.running), np.array(rewards.by_step.reward[level])
        assert (running * means).sum() / EPISODES == pytest.approx(np.mean(values))
    both = np.add(total["option"], total["action"])
    np.testing.assert_allclose(both - terms["task"]["sub_goal"], total["task"], atol=1e-9)
    assert set(terms["option"]["jerk"]) == {0.0}
    collided = np.array(rewards.by_episode.outcome) == "collision"
    failures = np.add(terms["option"]["failure"], terms["action"]["failure"])
    np.testing.assert_allclose(failures[collided], -SCENARIO.reward.sigma_3)
    assert rewards.by_outcome["collision"].episodes == collided.sum() > 0


def test_mean_attention_is_the_mean_over_the_steps_of_each_option(learned: Any) -> None:
    steps = record_steps(learned, TASK, 3)
    means, weights = mean_attention(learned, steps), learned.attention(steps.observations, steps.option)
    assert means is not None
    for option, name in enumerate(means):
        np.testing.assert_allclose([*means[name].values()], weights[steps.option == option].mean(axis=0), atol=1e-6)


def test_methods_without_attention_and_options_without_steps_are_left_out() -> None:
    class Method:
        attention = False

    steps = record_steps(Attentive(equal), TASK, 2)
    means = mean_attention(Attentive(equal), steps)
    assert means is not None
    assert [*means] == ["stop"]
    assert mean_attention(Attentive(equal, Method()), steps) is None
    assert mean_attention(Attentive(equal), replace(steps, option=np.full_like(steps.option, -1))) is None


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        (lambda obs, _: equal(obs, obs)[:, :3], r"attention has shape \(\d+, 3\)"),
        (lambda obs, _: equal(obs, obs) * np.nan, "return finite"),
        (lambda obs, _: [[1] * SIZE] * len(obs), "type int64"),
        (lambda *_: 1 // 0, "attention raised ZeroDivisionError"),
    ],
)
def test_an_attention_that_is_none_is_refused_in_one_line(answer: Any, said: str) -> None:
    with pytest.raises(AgentError, match=said) as refusal:
        attention_over_episode(Attentive(answer), TASK)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("episode", [-1, 10**9])
def test_episodes_outside_the_test_set_are_refused(episode: int) -> None:
    with pytest.raises(SeedError):
        attention_over_episode(rule("rule-1"), TASK, episode)


@pytest.mark.parametrize("episodes", [0, MAX_EPISODES + 1])
def test_too_few_and_too_many_episodes_are_refused(episodes: int) -> None:
    with pytest.raises(SeedError, match="ask for 1 to 10000"):
        record_steps(rule("rule-1"), TASK, episodes)
