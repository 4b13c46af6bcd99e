"""What foreseeing an episode costs on one core, in every scenario with scripted traffic."""

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from benchmarks.systems import Report
from hhrl_agents.rules.oracle import Oracle
from hhrl_envs import SCENARIOS, Scenario, Simulator

WORLDS, BAR = 100, 10
SCRIPTED = [scenario for scenario in SCENARIOS.values() if not scenario.learned_fronts]


@pytest.mark.usefixtures("one_core")
@pytest.mark.parametrize("scenario", SCRIPTED, ids=lambda scenario: scenario.id)
def test_foreseeing(benchmark: BenchmarkFixture, report: Report, scenario: Scenario) -> None:
    simulator, oracle = Simulator(scenario, WORLDS), Oracle(scenario)
    simulator.reset(np.arange(WORLDS))
    benchmark.pedantic(oracle.foresee, (simulator,), rounds=3, warmup_rounds=1)
    if benchmark.stats is not None:
        milliseconds = 1000.0 * benchmark.stats.stats.min / WORLDS
        report(f"oracle, {scenario.id}", f"{milliseconds:.2f} ms an episode", "", "", "", f"at most {BAR} ms")
