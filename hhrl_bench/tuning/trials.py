"""Trials: candidates drive the same worlds side by side, and every step of theirs is paid for.

Every candidate sees the same worlds (common random numbers), so that two candidates differ by themselves alone.
"""

from collections.abc import Sequence
from math import fsum

import numpy as np

from hhrl_agents import Agent, Decision
from hhrl_bench.evaluation.episodes import Totals
from hhrl_bench.evaluation.metrics import HEADLINE, METRICS
from hhrl_bench.evaluation.rollout import Rollout
from hhrl_envs import Outcome, Scenario
from hhrl_envs.arrays import Flags, Floats, Floats32, Keys

_RUNNING = int(Outcome.RUNNING)


class Budget:
    """Environment steps of the ego that a search may take.

    Attributes:
        total: all of them.
        spent: how many have been taken.
    """

    def __init__(self, total: int) -> None:
        self.total, self.spent = total, 0

    def allows(self, steps: int) -> bool:
        """Return whether so many steps more are within it."""
        return self.spent + steps <= self.total


class SideBySide:
    """Agents of which each drives a part of the rows, all parts being equally long."""

    def __init__(self, agents: Sequence[Agent]) -> None:
        self._agents = agents

    def reset(self, mask: Flags) -> None:
        """Tell every agent which of its rows, of all bool [B], start an episode."""
        for agent, part in zip(self._agents, np.split(mask, len(self._agents)), strict=True):
            agent.reset(part)

    def act(self, observations: Floats32) -> Decision:
        """Return the decisions of all rows; see `Agent.act`."""
        parts = np.split(observations, len(self._agents))
        decisions = [agent.act(part) for agent, part in zip(self._agents, parts, strict=True)]
        return Decision(*map(np.concatenate, zip(*decisions, strict=True)))


def scores(candidates: Sequence[Agent], scenario: Scenario, seeds: Keys, budget: Budget) -> Floats | None:
    """Return the mean score of every candidate, float64 [N], in the same worlds; None if the budget ends before.

    A step that the budget has no room for, with all who are still driving, is not taken. The sums are exact, so the
    means are the same on every machine.
    """
    score = METRICS[HEADLINE]
    rollout = Rollout(SideBySide(candidates), scenario, np.tile(seeds, len(candidates)))
    totals, running = Totals(rollout, [METRICS[key] for key in score.needs]), len(rollout.seeds)
    steps = iter(rollout)
    while running > 0:
        if not budget.allows(running):
            return None
        step = next(steps)
        totals.add(step)
        budget.spent += running
        running = int((step.results.outcomes == _RUNNING).sum())
    values = score.values(totals.records()).reshape(len(candidates), len(seeds))
    return np.array([fsum(own) / len(own) for own in values.tolist()])
