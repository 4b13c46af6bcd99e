from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hhrl_agents import RULES
from hhrl_agents.rules.oracle import Oracle
from hhrl_bench.evaluation.episodes import EpisodeRecords
from hhrl_bench.evaluation.metrics import METRICS
from hhrl_bench.evaluation.paired_evaluation import play_task
from hhrl_bench.evaluation.score import BOUNDS, Weights, fewest_steps, score
from hhrl_bench.tasks.tasks import get_task
from hhrl_envs import Outcome, Simulator, get_scenario

EPISODES = 12
PARTS = ("fewest_steps", "uncomfortable", "too_close", "progress", "comfort", "margin", "score")


def plainly(task_id: str, rule: str, seed: int) -> tuple[float, ...]:
    """Return the parts of the score of one episode, from the vehicles' own motions."""
    scenario = get_scenario(get_task(task_id).scenario)
    simulator, agent, oracle = Simulator(scenario, 1), RULES[rule](scenario), Oracle(scenario)
    simulator.reset(np.array([seed], np.uint64))
    oracle.foresee(simulator)
    steps, uncomfortable, too_close, before = 0, 0, 0, simulator.vehicles(0)[0][2]
    while simulator.outcomes[0] == Outcome.RUNNING:
        simulator.step(agent.act(simulator.observations).action)
        steps += 1
        (position, speed, accel), *fronts = simulator.vehicles(0)
        jerk, before = (accel - before) / scenario.dt, accel
        low, high = BOUNDS.accel
        uncomfortable += not (low <= accel <= high and abs(jerk) <= BOUNDS.jerk)
        for front in fronts[:1]:
            gap, closing = front[0] - scenario.vehicle.length - position, speed - front[1]
            if not gap < scenario.sensor.front_range:  # nor where there is no front vehicle: NaN
                continue
            kept = max((speed**2 - front[1] ** 2) / (2.0 * scenario.vehicle.max_decel), scenario.reward.safe_gap)
            near = closing > 0.0 and max(gap, 0.0) / closing < BOUNDS.time_to_collision
            too_close += max(gap, 0.0) < kept or near
    fewest = int(oracle.fewest[0])
    progress = min(fewest / steps, 1.0) if fewest else 1.0
    comfort, margin = 1.0 - uncomfortable / steps, 1.0 - too_close / steps
    gate = float(simulator.outcomes[0] == Outcome.SUCCESS)
    return fewest, uncomfortable, too_close, progress, comfort, margin, gate * progress * (comfort + margin) / 2.0


@pytest.mark.parametrize("task_id", ["stop-line-v0", "solo-stop-v0", "stop-line-noisy-v0", "red-light-v0"])
@pytest.mark.parametrize("rule", ["rule-2", "rule-4"])
def test_the_score_is_that_of_the_vehicles_themselves(task_id: str, rule: str) -> None:
    task = get_task(task_id)
    records = play_task(RULES[rule](get_scenario(task.scenario)), task, task.test.take(EPISODES)).records
    known = np.array([plainly(task_id, rule, int(seed)) for seed in records.seed])
    for key, values in zip(PARTS, known.T, strict=True):
        np.testing.assert_allclose(METRICS[key].values(records), values, rtol=1e-9, err_msg=key)


def episodes(outcome: Outcome, steps: int, fewest: int, uncomfortable: int = 0, too_close: int = 0) -> EpisodeRecords:
    counts = {"fewest_steps": fewest, "uncomfortable": uncomfortable, "too_close": too_close}
    measured = {key: np.array([count], np.int32) for key, count in counts.items()}
    seed, ended = np.zeros(1, np.uint64), np.array([outcome], np.int8)
    return EpisodeRecords(seed, ended, np.array([steps], np.int32), measured)


@pytest.mark.parametrize("outcome", [one for one in Outcome if one not in {Outcome.SUCCESS, Outcome.RUNNING}])
def test_without_success_it_is_zero(outcome: Outcome) -> None:
    assert score(episodes(outcome, 100, 100)).tolist() == [0.0]


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"steps": 100, "fewest": 100}, 1.0),
        ({"steps": 200, "fewest": 100}, 0.5),
        ({"steps": 100, "fewest": 104}, 1.0),  # quicker than the plan, by what its steps and levels cost
        ({"steps": 100, "fewest": 0}, 1.0),  # no way was found, and yet there was one
        ({"steps": 100, "fewest": 80, "uncomfortable": 10}, 0.8 * 0.95),
        ({"steps": 100, "fewest": 80, "uncomfortable": 10, "too_close": 30}, 0.8 * 0.8),
    ],
)
def test_it_is_progress_times_the_mean_of_comfort_and_margin(given: dict[str, int], expected: float) -> None:
    np.testing.assert_allclose(score(episodes(Outcome.SUCCESS, **given)), [expected])


def test_weights_move_it() -> None:
    one = episodes(Outcome.SUCCESS, 100, 81, uncomfortable=20, too_close=40)
    np.testing.assert_allclose(score(one, Weights(comfort=3.0)), [0.81 * (3 * 0.8 + 0.6) / 4])
    np.testing.assert_allclose(score(one, Weights(margin=0.0)), [0.81 * 0.8])
    np.testing.assert_allclose(score(one, Weights(progress=0.5)), [0.9 * 0.7])


def test_learned_front_vehicles_have_no_score() -> None:
    task = get_task("platoon-v0")
    records = play_task(RULES["rule-4"](get_scenario(task.scenario)), task, task.test.take(3)).records
    assert "fewest_steps" not in records.measured
    assert not METRICS["score"].follows_from(records.measured)
    assert METRICS["comfort"].follows_from(records.measured)


def test_equal_worlds_are_foreseen_once(monkeypatch: pytest.MonkeyPatch) -> None:
    scenario, seeds = get_scenario("stop-line-v0"), np.array([7, 8, 7], np.uint64)
    simulator = Simulator(scenario, 3)
    rollout: Any = SimpleNamespace(simulator=simulator, seeds=seeds)
    fewest = fewest_steps(rollout)
    assert fewest is not None
    assert fewest[0] == fewest[2]
    monkeypatch.setattr("hhrl_bench.evaluation.score.Oracle", None)  # nothing is searched for again
    again = fewest_steps(rollout)
    assert again is not None
    assert again.tolist() == fewest.tolist()
