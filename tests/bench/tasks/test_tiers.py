from dataclasses import replace

import numpy as np
import pytest

from hhrl_agents import RULES, Agent
from hhrl_agents.rules.rule_plus import RulePlus
from hhrl_agents.rules.tuned_rule import ROBUST, TUNED
from hhrl_agents.rules.tuning import Tuning
from hhrl_bench.evaluation.paired_evaluation import play
from hhrl_bench.tasks.tasks import TASKS
from hhrl_envs import SCENARIOS, Outcome, Scenario, Simulator

TIERS = [SCENARIOS[f"stop-line-{tier}-v0"] for tier in ("dense", "erratic", "wet", "noisy")]
DENSE, ERRATIC, WET, NOISY = TIERS
EPISODES = 1000
EACH_TIER = pytest.mark.parametrize("tier", TIERS, ids=lambda tier: tier.id)

_GENTLE = Tuning(headway=2.1, decel=0.8, response=1.1, accel=1.1)
_SLOWLY = replace(DENSE.road, speed_limit=8.0, start_speed=(0.0, 0.0))

ANSWERS = {
    DENSE.id: RulePlus(replace(DENSE, road=_SLOWLY)),
    ERRATIC.id: RulePlus(ERRATIC, Tuning(headway=2.5)),
    WET.id: RulePlus(WET, Tuning(decel=1.0)),
    NOISY.id: RulePlus(NOISY, _GENTLE),
}
"""For each tier the same rule, driven by somebody who knows the tier: slower, further away, or more gently."""


def success(agent: Agent, tier: Scenario) -> float:
    records = play(agent, tier, TASKS[tier.id].test.take(EPISODES), rows=EPISODES).records
    return float(np.mean(records.outcome == Outcome.SUCCESS))


@EACH_TIER
def test_nearly_every_world_is_feasible(tier: Scenario) -> None:
    simulator = Simulator(tier, EPISODES)
    simulator.reset(TASKS[tier.id].test.take(EPISODES))
    assert simulator.feasible.mean() >= 0.985


@EACH_TIER
def test_no_rule_solves_a_tier_that_has_not_been_tuned_in_it(tier: Scenario) -> None:
    untuned = {name: make for name, make in RULES.items() if name not in {TUNED, ROBUST}}
    shares = {name: success(make(tier), tier) for name, make in untuned.items()}
    best = max(shares, key=lambda name: shares[name])
    assert 0.7 <= shares[best] <= 0.92, shares


@EACH_TIER
def test_another_reaction_to_the_same_observations_does_far_better(tier: Scenario) -> None:
    assert success(ANSWERS[tier.id], tier) >= success(RulePlus(tier), tier) + 0.05
