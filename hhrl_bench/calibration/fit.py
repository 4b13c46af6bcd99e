"""The calibration: a seeded search for the world in which Rules 1 to 4 come to the paper's Table I.

Every candidate world is judged by the same episode seeds (common random numbers), so that two candidates differ by
their parameters alone. The search sees validation seeds only; what it found is scored on test seeds.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import OptimizeResult, differential_evolution

from hhrl_agents.rules.paper_rules import PAPER_RULES, RuleAgent
from hhrl_bench.calibration import space
from hhrl_bench.calibration.target import COLUMNS, ROWS, FloatArray, objective
from hhrl_bench.progress import Update, silent
from hhrl_bench.tasks.seeds import UInt64Array
from hhrl_bench.tasks.tasks import VALIDATION
from hhrl_envs import InputError, Outcome, Scenario, Simulator
from hhrl_envs.arrays import Flags
from hhrl_envs.simulation import rewards

ENDINGS = (Outcome.COLLISION, Outcome.NOT_STOP, Outcome.TIMEOUT, Outcome.SUCCESS)
INFEASIBLE = 1e4  # the objective of a world that draws no feasible episode
POPULATION = 3  # candidates of a generation for each parameter


class Fit(NamedTuple):
    """The best parameters found, by name, their objective, and the number of worlds tried."""

    parameters: dict[str, float]
    objective: float
    worlds: int


def score(scenario: Scenario, seeds: UInt64Array) -> FloatArray:
    """Return the nine columns of Table I for Rules 1 to 4, float64 [4, 9], over the episodes of ``seeds`` [N].

    The rules play side by side in one batch of 4 N rows: the numbers of an evaluation, in a third of its time.
    """
    agent = _side_by_side(scenario)
    simulator = Simulator(scenario, len(ROWS) * len(seeds))
    simulator.reset(np.tile(seeds, len(ROWS)))
    rows, sums = np.arange(simulator.num_rows), np.zeros((4, simulator.num_rows))
    while (simulator.outcomes == Outcome.RUNNING).any():
        option, action = agent.act(simulator.observations)
        simulator.step(action)
        terms = simulator.terms
        sums[0] += simulator.reward_option[rows, option]
        sums[1] += simulator.reward_action[rows, option]
        sums[2] += terms[:, rewards.UNSMOOTH] < 0.0
        sums[3] -= terms[:, rewards.UNSAFE_SSL] + terms[:, rewards.UNSAFE_FFV]
    ended = [simulator.outcomes == ending for ending in ENDINGS]
    columns = np.stack([*sums[:2], simulator.steps, *sums[2:], *ended])
    means: FloatArray = columns.reshape(len(COLUMNS), len(ROWS), len(seeds)).mean(axis=2).T
    return means


def _side_by_side(scenario: Scenario) -> RuleAgent:
    """Return the agent that plays rule r in the r-th part of its rows."""
    rules = [PAPER_RULES[row.counterpart](scenario).follow for row in ROWS]

    def follow(state: FloatArray) -> Flags:
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


def _cost(seeds: UInt64Array) -> Callable[[FloatArray], float]:
    def cost(vector: FloatArray) -> float:
        try:
            return objective(score(space.build(space.named(vector)), seeds))
        except InputError:
            return INFEASIBLE

    return cost
