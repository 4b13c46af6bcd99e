"""How severe an episode got, against a plain loop that steps one world and looks at its vehicles."""

from math import inf, isfinite, nan
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hhrl_agents import RULES
from hhrl_bench.evaluation.metrics import METRICS
from hhrl_bench.evaluation.paired_evaluation import play_task
from hhrl_bench.evaluation.rollout import Step
from hhrl_bench.tasks.tasks import get_task
from hhrl_envs import Outcome, Simulator, get_scenario

EPISODES = 12


def plainly(task_id: str, rule: str, seed: int) -> tuple[float, float, float]:
    """Return impact speed, smallest gap and smallest time to collision, from positions and speeds; NaN for none."""
    scenario = get_scenario(get_task(task_id).scenario)
    agent, simulator = RULES[rule](scenario), Simulator(scenario, 1)
    simulator.reset([seed])
    agent.reset(np.ones(1, np.bool_))
    impact, gap, ttc = nan, inf, inf
    while simulator.outcomes[0] == Outcome.RUNNING:
        simulator.step(agent.act(simulator.observations).action)
        (x, v, _), front = simulator.vehicles(0)[0], (*simulator.vehicles(0)[1:], (nan, nan, nan))[0]
        room, closing = max(front[0] - scenario.vehicle.length - x, 0.0), v - front[1]
        if room < scenario.sensor.front_range:  # not where there is no front vehicle either: NaN
            gap = min(gap, room)
            ttc = min(ttc, room / closing, 10.0) if closing > 0.0 else ttc
        if simulator.outcomes[0] == Outcome.COLLISION:
            impact = closing
    return impact, gap if isfinite(gap) else nan, ttc if isfinite(ttc) else nan


@pytest.mark.parametrize("task_id", ["stop-line-v0", "solo-stop-v0", "stop-line-noisy-v0"])
@pytest.mark.parametrize("rule", ["rule-2", "rule-4"])
def test_severity_is_that_of_the_vehicles_themselves(task_id: str, rule: str) -> None:
    task = get_task(task_id)
    scenario = get_scenario(task.scenario)
    records = play_task(RULES[rule](scenario), task, task.test.take(EPISODES)).records
    known = np.array([plainly(task_id, rule, int(seed)) for seed in records.seed])
    np.testing.assert_allclose(records.impact_speed, known[:, 0], rtol=1e-9)
    np.testing.assert_allclose(records.smallest_gap, known[:, 1], rtol=1e-9)
    np.testing.assert_allclose(records.smallest_ttc, known[:, 2], rtol=1e-9)
    assert (np.isfinite(records.impact_speed) == (records.outcome == Outcome.COLLISION)).all()


def found(*steps: tuple[float, float, float, bool, Outcome]) -> list[float]:
    accumulations: list[Any] = [METRICS[key].of for key in ("impact_speed", "smallest_gap", "smallest_ttc")]
    rollout = SimpleNamespace(seeds=np.zeros(1, np.uint64))
    totals = [accumulation.start(rollout) for accumulation in accumulations]
    for gap, ego, front, running, outcome in steps:
        ahead = np.array([gap]), np.array([ego - front])
        world: Any = SimpleNamespace(ahead=lambda _, ahead=ahead: ahead, scenario=get_scenario("stop-line-v0"))
        results: Any = SimpleNamespace(outcomes=np.array([outcome], np.int8))
        nothing: Any = None
        step = Step(nothing, nothing, nothing, nothing, np.array([running]), results, world, (0,))
        for accumulation, total in zip(accumulations, totals, strict=True):
            accumulation.add(total, step)
    return [float(total[0]) for total in totals]


def test_the_worst_counts_and_nothing_after_the_end() -> None:
    on = Outcome.RUNNING
    np.testing.assert_equal(found((100.0, 9.0, 1.0, True, on)), [nan, nan, nan])  # out of range
    np.testing.assert_equal(found((10.0, 5.0, 5.0, True, on)), [nan, 10.0, nan])  # never closing
    np.testing.assert_equal(found((10.0, 7.0, 2.0, True, on), (8.0, 3.0, 2.0, True, on)), [nan, 8.0, 2.0])
    hit = (0.0, 4.0, 1.5, True, Outcome.COLLISION)
    after = (-3.0, 9.0, 0.0, False, Outcome.COLLISION)
    np.testing.assert_equal(found((10.0, 4.0, 2.0, True, on), hit, after), [2.5, 0.0, 0.0])
