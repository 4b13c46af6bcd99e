"""What both levels did over all steps: rewards term by term, and which option was selected how often and where."""

import numpy as np

from hhrl_bench.analysis.records import (
    EpisodeRewardsRecord,
    LevelName,
    LevelRecord,
    LevelRewardsRecord,
    LevelsRecord,
    OptionUsageRecord,
    Shares,
    StepRewardsRecord,
    TermName,
    UsageBinRecord,
    UsageRecord,
    outcome_name,
    series,
)
from hhrl_bench.analysis.steps import Steps
from hhrl_bench.evaluation.guarded_agent import OPTIONS
from hhrl_envs import SUB_GOALS, Scenario
from hhrl_envs import observation as obs
from hhrl_envs.arrays import Flags, Floats, Ints
from hhrl_envs.simulation import rewards

Levels = dict[LevelName, Floats]
Terms = dict[LevelName, dict[TermName, Floats]]

SUB_GOAL = [rewards.TIME, rewards.TIMEOUT, rewards.SUCCESS]
BIN = 10.0  # m; the width of a bin of distances


def rewards_by_level(steps: Steps) -> Levels:
    """Return every step's r^option, r^action and r^task, float64 [n]; r^task alone where no option is selected."""
    if not steps.hierarchical:
        return {"task": steps.reward_task}
    return {"option": steps.reward_option, "action": steps.reward_action, "task": steps.reward_task}


def terms_by_level(steps: Steps) -> Terms:
    """Return every step's terms of each level, float64 [n], which add up to the level's reward.

    The option level answers for the unselected sub-goals, the action level for the selected one and for the jerk; the
    sub-goal reward sr counts at both. See ``hhrl_envs.simulation.rewards``.
    """
    sub_goal, jerk = steps.terms[:, SUB_GOAL].sum(axis=1), steps.terms[:, rewards.UNSMOOTH]
    unsafe, failure = steps.terms[:, rewards.UNSAFE], steps.terms[:, rewards.FAILURE]
    task = _named(sub_goal, unsafe.sum(axis=1), failure.sum(axis=1), jerk)
    if not steps.hierarchical:
        return {"task": task}
    own = np.arange(len(SUB_GOALS)) == steps.option[:, None]
    return {
        "option": _named(sub_goal, _sum(unsafe, ~own), _sum(failure, ~own), np.zeros_like(jerk)),
        "action": _named(sub_goal, _sum(unsafe, own), _sum(failure, own), jerk),
        "task": task,
    }


def _sum(terms: Floats, chosen: Flags) -> Floats:
    """Return the sum over the chosen sub-goals, float64 [n], of their terms [n, K]."""
    sums: Floats = np.where(chosen, terms, 0.0).sum(axis=1)
    return sums


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


def _means(totals: Levels, terms: Terms, chosen: Flags) -> LevelsRecord:
    levels = {
        level: LevelRecord(
            total=float(values[chosen].mean()),
            terms={name: float(term[chosen].mean()) for name, term in terms[level].items()},
        )
        for level, values in totals.items()
    }
    return LevelsRecord(episodes=int(chosen.sum()), levels=levels)


def _named(sub_goal: Floats, unsafe: Floats, failure: Floats, jerk: Floats) -> dict[TermName, Floats]:
    return {"sub_goal": sub_goal, "unsafe": unsafe, "failure": failure, "jerk": jerk}


def option_usage(steps: Steps, scenario: Scenario) -> OptionUsageRecord | None:
    """Return which options were selected in the steps of the scenario's episodes; None where none were.

    Distances are those that the agent saw: with noise, if the sensors have any.
    """
    if not steps.hierarchical:
        return None
    state, sensor = obs.to_si(steps.observations).astype(np.float64), scenario.sensor
    return OptionUsageRecord(
        overall=_usage(steps, np.full(len(steps.seeds), True)),
        by_outcome={outcome_name(code): _usage(steps, steps.outcomes == code) for code in np.unique(steps.outcomes)},
        by_d_d=_binned(steps.option, state[:, obs.D_D], sensor.line_range),
        by_d_f=_binned(steps.option, state[:, obs.D_F], sensor.front_range),
    )


def _usage(steps: Steps, chosen: Flags) -> UsageRecord:
    """Return the option usage of the chosen episodes, bool [N]."""
    picked = chosen[steps.episode]
    switched = (np.diff(steps.option) != 0) & (np.diff(steps.episode) == 0) & picked[1:]
    episodes, count = int(chosen.sum()), int(picked.sum())
    return UsageRecord(
        episodes=episodes, steps=count, switches=int(switched.sum()) / episodes, share=_shares(steps.option[picked])
    )


def _binned(option: Ints, distance: Floats, reach: float) -> tuple[UsageBinRecord, ...]:
    """Return the option usage by distance, in bins up to the sensor's ``reach``, and beyond it."""
    lows = np.arange(0.0, reach, BIN)
    place = np.searchsorted([*lows[1:], reach], distance, side="right")
    bounds = [*zip(lows.tolist(), [*lows[1:].tolist(), reach], strict=True), (reach, None)]
    return tuple(_bin(option[place == i], low, high) for i, (low, high) in enumerate(bounds))


def _bin(option: Ints, low: float, high: float | None) -> UsageBinRecord:
    return UsageBinRecord(low=low, high=high, steps=len(option), share=_shares(option) if len(option) else None)


def _shares(option: Ints) -> Shares:
    return {name: float((option == code).mean()) for name, code in OPTIONS.items()}
