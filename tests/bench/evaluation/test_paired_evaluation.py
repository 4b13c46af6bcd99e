"""Evaluation is paired, repeatable, and hard on agents that answer nonsense."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import hhrl_bench
from hhrl_agents import RULES, Agent, Decision
from hhrl_bench import evaluate
from hhrl_bench.errors import AgentError, SeedError
from hhrl_bench.evaluation.episodes import EpisodeRecords, join
from hhrl_bench.evaluation.metrics import METRICS, means
from hhrl_bench.evaluation.paired_evaluation import BATCH_ROWS, play
from hhrl_bench.tasks.tasks import TEST, get_task
from hhrl_envs import Option, Outcome, Simulator, get_scenario
from hhrl_envs.simulation import rewards

SCENARIO = get_scenario("stop-line-v0")
Answer = Callable[[NDArray[np.float32]], Any]


class Stub:
    """A flat agent that answers what it is told to."""

    def __init__(self, answer: Answer) -> None:
        self.answer = answer
        self.batches: list[tuple[int, ...]] = []

    def reset(self, mask: NDArray[np.bool_]) -> None:
        assert mask.all()

    def act(self, observations: NDArray[np.float32]) -> Any:
        self.batches.append(observations.shape)
        return self.answer(observations)


def flat(action: int) -> Stub:
    return Stub(lambda obs: Decision(np.full(len(obs), -1), np.full(len(obs), action)))


def played(
    agent: Agent, task: str = "stop-line-v0", episodes: int = 1000, option: Option | None = None
) -> EpisodeRecords:
    return evaluate(agent, task, episodes, option).records


def equal(a: EpisodeRecords, b: EpisodeRecords) -> bool:
    ours, theirs = a.arrays(), b.arrays()
    return all(np.array_equal(ours[name], theirs[name], equal_nan=name != "seed") for name in ours)


@pytest.mark.parametrize("rule", RULES)
def test_the_same_evaluation_twice_gives_the_same_digits(rule: str) -> None:
    first, again = (played(RULES[rule](SCENARIO), "stop-line-v0", episodes=60) for _ in range(2))
    assert equal(first, again)
    assert first.digest() == again.digest()


def test_episode_i_is_the_same_world_for_every_agent_and_number_of_episodes() -> None:
    few, many, other = played(flat(0), episodes=7), played(flat(0), episodes=520), played(flat(3), episodes=7)
    assert few.seed.tolist() == other.seed.tolist() == [TEST.start + i for i in range(7)]
    assert len(many) == 520
    assert many.seed[BATCH_ROWS] == TEST.start + BATCH_ROWS
    assert equal(few, join([many], 7))


def test_the_number_of_rows_does_not_change_a_rules_episodes() -> None:
    seeds = TEST.take(23)
    wide, narrow = (play(RULES["rule-4"](SCENARIO), SCENARIO, seeds, rows=rows).records for rows in (23, 5))
    assert equal(wide, narrow)


def test_an_agent_always_sees_batches_of_one_shape() -> None:
    agent = flat(0)
    played(agent, episodes=3)
    played(agent, episodes=BATCH_ROWS + 1)
    assert set(agent.batches) == {(BATCH_ROWS, 11)}


def test_an_agent_cannot_touch_the_simulation_through_its_observations() -> None:
    def scribble(observations: NDArray[np.float32]) -> Decision:
        observations[:] = 0.0
        return Decision(np.full(len(observations), -1), np.full(len(observations), 3))

    assert equal(played(Stub(scribble), episodes=20), played(flat(3), episodes=20))


def test_the_records_are_the_sums_of_what_the_simulator_says() -> None:
    """One row alone, stepped by hand, against the evaluation's arrays."""
    agent, index = RULES["rule-2"](SCENARIO), 5
    records = played(agent, episodes=8)
    simulator = Simulator(SCENARIO, 1)
    simulator.reset([TEST.start + index])
    task = option = action = unsafe = 0.0
    unsmooth = 0
    while simulator.outcomes[0] == Outcome.RUNNING:
        simulator.step(agent.act(simulator.observations).action)
        task += simulator.rewards[0]
        option += simulator.reward_option[0, Option.SSL]
        action += simulator.reward_action[0, Option.SSL]
        unsmooth += int(simulator.terms[0, rewards.UNSMOOTH] < 0)
        unsafe -= simulator.terms[0, rewards.UNSAFE].sum()
    assert records.outcome[index] == simulator.outcomes[0]
    assert records.steps[index] == simulator.steps[0]
    assert records.unsmooth[index] == unsmooth
    for field, value in (("task", task), ("option", option), ("action", action)):
        assert getattr(records, f"return_{field}")[index] == pytest.approx(value, rel=1e-12)
    assert records.unsafe[index] == pytest.approx(unsafe, rel=1e-12)


def test_a_held_option_is_the_rule_that_always_selects_it() -> None:
    following, stopping = RULES["rule-1"](SCENARIO), RULES["rule-2"](SCENARIO)
    free = RULES["rule-4"](SCENARIO)
    assert equal(played(free, episodes=40, option=Option.FFV), played(following, episodes=40))
    assert equal(played(free, episodes=40, option=Option.SSL), played(stopping, episodes=40))
    assert not equal(played(free, episodes=40), played(stopping, episodes=40))


def test_a_flat_agent_has_no_option_to_hold() -> None:
    with pytest.raises(AgentError, match="flat agent has no option"):
        played(flat(0), episodes=1, option=Option.SSL)


def test_a_flat_agent_has_no_option_and_action_returns() -> None:
    records = played(flat(0), episodes=4)
    assert np.isnan(records.return_option).all()
    assert np.isnan(records.return_action).all()
    assert np.isfinite(records.return_task).all()


def test_the_rates_of_the_metrics_add_up_to_one() -> None:
    numbers = means(played(RULES["rule-2"](SCENARIO), episodes=50))
    assert sum(numbers[key] for key, metric in METRICS.items() if metric.is_rate) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        (lambda obs: [0] * len(obs), r"returned list; return Decision\(option, action\), or an array of actions"),
        (lambda obs: np.zeros(len(obs) - 1, int), r"shape \(499,\)"),
        (lambda obs: (np.full(len(obs), -1), np.zeros(len(obs) - 1, int)), r"shape \(499,\)"),
        (lambda obs: (np.full(len(obs), -1), np.full(len(obs), np.nan)), "type float64"),
        (lambda obs: (np.full(len(obs), -1), np.full(len(obs), SCENARIO.num_actions)), "vehicle.levels, 0 to 5$"),
        (lambda obs: (np.full(len(obs), -1), np.full(len(obs), -1)), "actions go from -1 to -1"),
        (
            lambda obs: (np.full(len(obs), 2), np.zeros(len(obs), int)),
            r"options go from 2 to 2; return -1 \(flat\), 0 \(SSL\) or 1 \(FFV\)$",
        ),
        (lambda obs: (np.full(len(obs), -1), [[0], [0, 1]]), "actions are no array"),
        (lambda _: 1 // 0, r"raised ZeroDivisionError: .* \(test_paired_evaluation.py, line \d+\)"),
    ],
)
def test_nonsense_is_said_in_one_line(answer: Answer, said: str) -> None:
    with pytest.raises(AgentError, match=said) as caught:
        played(Stub(answer), episodes=2)
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize("episodes", [0, -1, 10**5 + 1])
def test_impossible_numbers_of_episodes(episodes: int) -> None:
    with pytest.raises(SeedError, match="ask for 1 to 100000"):
        played(flat(0), episodes=episodes)


def test_a_digest_names_every_array() -> None:
    records = played(flat(0), episodes=3)
    for name in records.arrays():
        changed = {key: array.copy() for key, array in records.arrays().items()}
        changed[name][1] = 77
        assert records.with_arrays(changed).digest() != records.digest()


def test_the_package_offers_evaluate_and_load_agent() -> None:
    assert len(hhrl_bench.evaluate(hhrl_bench.load_agent("rule-1"), "stop-line-v0", episodes=2)) == 2
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        hhrl_bench.nothing  # noqa: B018
    assert get_task("stop-line-v0").test == TEST
