"""Trials: candidates drive the same worlds side by side, and every step of theirs is paid for.

Every candidate sees the same worlds (common random numbers), so that two candidates differ by themselves alone.
"""

from math import fsum

import numpy as np

from hhrl_agents import Agent
from hhrl_bench.evaluation.episodes import Totals
from hhrl_bench.evaluation.metrics import HEADLINE, METRICS
from hhrl_bench.evaluation.rollout import Rollout
from hhrl_envs import Outcome, Scenario
from hhrl_envs.arrays import Floats, Keys

_RUNNING = int(Outcome.RUNNING)


class Budget:
    """Environment steps of the ego that a search may take.

    Attributes:
        total: all of them.
        spent: how many have been taken.
    """

    def __init__(self, total: int, spent: int = 0) -> None:
        self.total, self.spent = total, spent

    def allows(self, steps: int) -> bool:
        """Return whether so many steps more are within it."""
        return self.spent + steps <= self.total


def scores(agent: Agent, candidates: int, scenario: Scenario, seeds: Keys, budget: Budget) -> Floats | None:
    """Return the mean score of every candidate, float64 [N], in the same worlds; None if the budget ends before.

    The agent drives them all: the rows of the first candidate come first. A step that the budget has no room for, with
    all who are still driving, is not taken. The sums are exact, so the means are the same on every machine.
    """
    score = METRICS[HEADLINE]
    rollout = Rollout(agent, scenario, np.tile(seeds, candidates))
    totals, running = Totals(rollout, [METRICS[key] for key in score.needs]), len(rollout.seeds)
    steps = iter(rollout)
    while running > 0:
        if not budget.allows(running):
            return None
        step = next(steps)
        totals.add(step)
        budget.spent += running
        running = int((step.results.outcomes == _RUNNING).sum())
    values = score.values(totals.records()).reshape(candidates, len(seeds))
    return np.array([fsum(own) / len(own) for own in values.tolist()])
