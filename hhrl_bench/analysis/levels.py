"""Per-level rewards: what r^option and r^action came to, term by term."""

import numpy as np
from numpy.typing import NDArray

from hhrl_bench.analysis.records import (
    EpisodeRewardsRecord,
    LevelName,
    LevelRecord,
    LevelRewardsRecord,
    LevelsRecord,
    StepRewardsRecord,
    TermName,
    outcome_name,
    series,
)
from hhrl_bench.analysis.steps import FloatArray, Steps
from hhrl_envs.simulation import rewards

Levels = dict[LevelName, FloatArray]
Terms = dict[LevelName, dict[TermName, FloatArray]]

SUB_GOAL = [rewards.TIME, rewards.TIMEOUT, rewards.SUCCESS]
UNSAFE = [rewards.UNSAFE_SSL, rewards.UNSAFE_FFV]
FAILURE = [rewards.NOT_STOP, rewards.COLLISION]


def rewards_by_level(steps: Steps) -> Levels:
    """Return every step's r^option, r^action and r^task, float64 [n]; r^task alone where no option is selected."""
    if not steps.hierarchical:
        return {"task": steps.reward_task}
    return {"option": steps.reward_option, "action": steps.reward_action, "task": steps.reward_task}


def terms_by_level(steps: Steps) -> Terms:
    """Return every step's terms of each level, float64 [n], which add up to the level's reward.

    The option level answers for the unselected sub-goal, the action level for the selected one and for the jerk; the
    sub-goal reward sr counts at both. See ``hhrl_envs.simulation.rewards``.
    """
    sub_goal, jerk = steps.terms[:, SUB_GOAL].sum(axis=1), steps.terms[:, rewards.UNSMOOTH]
    unsafe, failure = steps.terms[:, UNSAFE], steps.terms[:, FAILURE]
    task = _named(sub_goal, unsafe.sum(axis=1), failure.sum(axis=1), jerk)
    if not steps.hierarchical:
        return {"task": task}
    rows, own, other = np.arange(len(steps.option)), steps.option, 1 - steps.option
    return {
        "option": _named(sub_goal, unsafe[rows, other], failure[rows, other], np.zeros_like(jerk)),
        "action": _named(sub_goal, unsafe[rows, own], failure[rows, own], jerk),
        "task": task,
    }


def level_rewards(steps: Steps) -> LevelRewardsRecord:
    """Return the rewards of every level: means, means by outcome, every episode, every step index."""
    totals = {level: steps.sums(values) for level, values in rewards_by_level(steps).items()}
    terms: Terms = {
        level: {name: steps.sums(values) for name, values in named.items()}
        for level, named in terms_by_level(steps).items()
    }
    outcomes = np.unique(steps.outcomes)
    return LevelRewardsRecord(
        overall=_means(totals, terms, np.full(len(steps.seeds), True)),
        by_outcome={outcome_name(code): _means(totals, terms, steps.outcomes == code) for code in outcomes},
        by_episode=EpisodeRewardsRecord(
            outcome=tuple(outcome_name(code) for code in steps.outcomes),
            total=series(totals),
            terms={level: series(named) for level, named in terms.items()},
        ),
        by_step=_by_step(steps),
    )


def _by_step(steps: Steps) -> StepRewardsRecord:
    lengths = np.bincount(steps.episode)
    index = np.arange(len(steps.episode)) - np.repeat(np.cumsum(lengths) - lengths, lengths)
    running = np.bincount(index)
    sums = {level: np.bincount(index, weights=values) for level, values in rewards_by_level(steps).items()}
    means = {level: values / running for level, values in sums.items()}
    return StepRewardsRecord(running=tuple(running.tolist()), reward=series(means))


def _means(totals: Levels, terms: Terms, chosen: NDArray[np.bool_]) -> LevelsRecord:
    levels = {
        level: LevelRecord(
            total=float(values[chosen].mean()),
            terms={name: float(term[chosen].mean()) for name, term in terms[level].items()},
        )
        for level, values in totals.items()
    }
    return LevelsRecord(episodes=int(chosen.sum()), levels=levels)


def _named(
    sub_goal: FloatArray, unsafe: FloatArray, failure: FloatArray, jerk: FloatArray
) -> dict[TermName, FloatArray]:
    return {"sub_goal": sub_goal, "unsafe": unsafe, "failure": failure, "jerk": jerk}
