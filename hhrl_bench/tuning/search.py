"""The search: differential evolution over the numbers of a rule, then a comparison of the best on fresh worlds.

Differential evolution (Storn and Price 1997, as scipy has it) draws, adds, multiplies and compares, and so does all
that judges its candidates: the same seed finds the same numbers on every machine. Few worlds make it quick and easily
misled. So what is left of the budget lets the last population, and the first guess, drive in worlds that are new.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, cast

import numpy as np
from scipy.optimize import Bounds, differential_evolution

from hhrl_agents.rules.rule_plus import RulePlus
from hhrl_agents.rules.tuning import FIRST_TUNING, Tuning, bounds
from hhrl_bench.errors import TuningError
from hhrl_bench.evaluation.results import Update
from hhrl_bench.tasks.tasks import Task
from hhrl_bench.tuning.trials import Budget, scores
from hhrl_envs import get_scenario
from hhrl_envs.arrays import Floats

POPULATION = 12
"""Candidates of a generation, the first guess among those of the first."""

SPREAD = 0.5
"""How far around the first guess the first generation lies, as a share of the way to the bounds."""

SEARCH_WORLDS = 12
"""Training worlds of each task in which all candidates of all generations drive."""

FRESH_EPISODES = 156
"""Episodes of each task that finalists drive together before the worse half of them goes."""

LAST = 3
"""How many finalists drive until the budget ends."""

SEARCH_SHARE = 0.6
"""The share of the budget that is for the evolution; the rest is for the finalists."""

DIGITS = 3
"""Digits after the point that a candidate's numbers are rounded to before it drives."""

_UNSTOPPABLE = -1.0  # tolerances of differential evolution with which only the budget ends it
_ENDLESS = 10**9


@dataclass(frozen=True)
class Found:
    """What a search has found.

    Attributes:
        tuning: the numbers, by their names.
        score: their mean score over the finalists' worlds, and over the tasks.
        worlds: how many worlds of each task that were.
        candidates: how many have been judged in all.
        env_steps: the environment steps spent.
    """

    tuning: Mapping[str, float]
    score: float
    worlds: int
    candidates: int
    env_steps: int


class _Judge(NamedTuple):
    """Who scores candidates in worlds of all tasks; a task counts as much as another."""

    tasks: Sequence[Task]
    budget: Budget

    def score(self, candidates: Sequence[Tuning], worlds: int, offset: int = 0) -> Floats | None:
        """Return the mean score of every candidate, float64 [N]; None if the budget ends before."""
        sums = np.zeros(len(candidates))
        for task in self.tasks:
            scenario, seeds = get_scenario(task.scenario), task.train.take(worlds, offset)
            agent = RulePlus(scenario, _stacked(candidates, worlds))
            own = scores(agent, len(candidates), scenario, seeds, self.budget)
            if own is None:
                return None
            sums += own
        means: Floats = sums / len(self.tasks)
        return means


def search(tasks: Sequence[Task], env_steps: int, seed: int, update: Update) -> Found:
    """Return the best numbers for the mean score over the tasks' training worlds that ``env_steps`` of the ego allow.

    ``update`` hears how many steps are done, and the best score so far.

    Raises:
        TuningError: if the steps do not do for a generation and for a comparison of the last one.
    """
    evolution = Budget(round(env_steps * SEARCH_SHARE))
    finalists, generations = _evolve(
        _Judge(tasks, evolution), seed, lambda note: update(evolution.spent, env_steps, note)
    )
    budget = Budget(env_steps, evolution.spent)
    best, score, worlds = _compare(_Judge(tasks, budget), finalists, lambda note: update(budget.spent, env_steps, note))
    if generations == 0 or worlds == 0:
        raise TuningError(
            f"{env_steps} steps are too few for a search; write more --env-steps, such as the task's budget"
        )
    numbers = {name: getattr(best, name) for name in bounds()}
    return Found(numbers, score, worlds, POPULATION * generations, budget.spent)


def _evolve(judge: _Judge, seed: int, update: Callable[[str], object]) -> tuple[list[Tuning], int]:
    """Return the last population that the judge's budget allows, behind the first guess, and how many it was."""
    generations, best, over = 0, -np.inf, False

    def cost(vectors: Floats) -> Floats:
        nonlocal generations, best, over
        over = over or not judge.budget.allows(judge.budget.spent // max(generations, 1))
        found = None if over else judge.score([_tuning(vector) for vector in vectors.T], SEARCH_WORLDS)
        if found is None:
            over = True
            return np.full(vectors.shape[1], np.inf)
        generations, best = generations + 1, max(best, float(found.max()))
        update(f"score {best:.3f}")
        return -found

    rng = np.random.default_rng(seed)
    low, high = (np.array([getattr(one, end) for one in bounds().values()]) for end in ("low", "high"))
    guess = np.array([getattr(FIRST_TUNING, name) for name in bounds()])
    first = guess + SPREAD * (low + (high - low) * rng.uniform(size=(POPULATION, len(low))) - guess)
    first[0] = guess
    last = differential_evolution(
        cast(Any, cost),
        Bounds(low, high),
        init=first,
        maxiter=_ENDLESS,
        tol=_UNSTOPPABLE,
        atol=_UNSTOPPABLE,
        rng=rng,
        callback=cast(Any, lambda intermediate_result: over),  # noqa: ARG005
        polish=False,
        updating="deferred",
        vectorized=True,
    )
    return [FIRST_TUNING, *map(_tuning, last.population)], generations


def _compare(judge: _Judge, finalists: list[Tuning], update: Callable[[str], object]) -> tuple[Tuning, float, int]:
    """Return the best of the finalists in fresh worlds, its mean score, and in how many worlds of each task that was.

    After every comparison the better half goes on, until the judge's budget ends.
    """
    sums, worlds = np.zeros(len(finalists)), 0
    while True:
        more = FRESH_EPISODES // len(finalists)
        own = judge.score(finalists, more, SEARCH_WORLDS + worlds)
        if own is None:
            return finalists[0], float(sums[0]) / max(worlds, 1), worlds
        sums, worlds = sums + more * own, worlds + more
        ranked = np.argsort(-sums, kind="stable")[: max((len(finalists) + 1) // 2, LAST)]
        finalists, sums = [finalists[place] for place in ranked], sums[ranked]
        update(f"score {sums[0] / worlds:.3f}")


def _tuning(vector: Floats) -> Tuning:
    """Return the numbers of a vector in the order of their bounds, rounded."""
    numbers = {name: round(value, DIGITS) for name, value in zip(bounds(), vector.tolist(), strict=True)}
    return replace(FIRST_TUNING, **numbers)


def _stacked(tunings: Sequence[Tuning], rows: int) -> Tuning:
    """Return the numbers of several as arrays: those of each for so many rows, which one agent then drives at once."""
    numbers: dict[str, Any] = {name: np.repeat([getattr(one, name) for one in tunings], rows) for name in bounds()}
    return replace(FIRST_TUNING, **numbers)
