"""The calibration: a seeded search for the world in which Rules 1 to 4 come to the paper's Table I.

Every candidate world is judged by the same episode seeds (common random numbers), so that two candidates differ by
their parameters alone. The search sees validation seeds only; what it found is scored on test seeds.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import OptimizeResult, differential_evolution

from hhrl_agents.rules import paper_rules
from hhrl_agents.rules.paper_rules import RuleAgent
from hhrl_bench.calibration import space
from hhrl_bench.calibration.target import COLUMNS, ROWS, objective
from hhrl_bench.evaluation.episodes import Totals
from hhrl_bench.evaluation.metrics import METRICS
from hhrl_bench.evaluation.results import Update, silent
from hhrl_bench.evaluation.rollout import Rollout
from hhrl_bench.tasks.tasks import VALIDATION
from hhrl_envs import InputError, Scenario
from hhrl_envs.arrays import Flags, Floats, Keys

INFEASIBLE = 1e4  # the objective of a world that draws no feasible episode
POPULATION = 3  # candidates of a generation for each parameter


class Fit(NamedTuple):
    """The best parameters found, by name, their objective, and the number of worlds tried."""

    parameters: dict[str, float]
    objective: float
    worlds: int


def score(scenario: Scenario, seeds: Keys) -> Floats:
    """Return the nine columns of Table I for Rules 1 to 4, float64 [4, 9], over the episodes of ``seeds`` [N].

    The rules drive side by side in one batch of 4 N rows: the numbers of an evaluation, in a third of its time.
    """
    metrics = [METRICS[column] for column in COLUMNS]
    rollout = Rollout(_side_by_side(scenario), scenario, np.tile(seeds, len(ROWS)))
    totals = Totals(rollout, metrics)
    for step in rollout:
        totals.add(step)
    records = totals.records()
    columns = np.stack([metric.values(records) for metric in metrics])
    means: Floats = columns.reshape(len(COLUMNS), len(ROWS), len(seeds)).mean(axis=2).T
    return means


def _side_by_side(scenario: Scenario) -> RuleAgent:
    """Return the agent that follows rule r in the r-th part of its rows."""
    rules = [paper_rules.RULES[row.counterpart](scenario).follow for row in ROWS]

    def follow(state: Floats) -> Flags:
        return np.concatenate([rule(part) for rule, part in zip(rules, np.split(state, len(rules)), strict=True)])

    return RuleAgent(scenario, follow)


def fit(seed: int, generations: int, episodes: int, update: Update = silent) -> Fit:
    """Return the best world of ``generations`` of differential evolution, every candidate on ``episodes`` episodes.

    ``update`` hears how many generations are done, and the best objective so far.
    """
    done = 0

    def report(intermediate_result: OptimizeResult) -> None:
        nonlocal done
        done += 1
        update(done, generations, f"objective {intermediate_result.fun:.2f}")

    best = differential_evolution(
        _cost(VALIDATION.take(episodes)),
        space.bounds(),
        x0=space.guess(),
        maxiter=generations,
        popsize=POPULATION,
        tol=0.0,
        rng=np.random.default_rng(seed),
        callback=report,
        polish=False,
    )
    return Fit(space.named(best.x), float(best.fun), int(best.nfev))


def _cost(seeds: Keys) -> Callable[[Floats], float]:
    def cost(vector: Floats) -> float:
        try:
            return objective(score(space.build(space.named(vector)), seeds))
        except InputError:
            return INFEASIBLE

    return cost
