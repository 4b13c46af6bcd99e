"""Option usage: which sub-goal is selected how often, where, and in episodes that end how."""

import numpy as np

from hhrl_bench.analysis.records import OptionUsageRecord, Shares, UsageBinRecord, UsageRecord, outcome_name
from hhrl_bench.analysis.steps import BoolArray, FloatArray, IntArray, Steps
from hhrl_bench.evaluation.guarded_agent import OPTIONS
from hhrl_envs import Scenario
from hhrl_envs import observation as obs

BIN = 10.0  # m


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


def _usage(steps: Steps, chosen: BoolArray) -> UsageRecord:
    """Return the option usage of the chosen episodes, bool [N]."""
    picked = chosen[steps.episode]
    switched = (np.diff(steps.option) != 0) & (np.diff(steps.episode) == 0) & picked[1:]
    episodes, count = int(chosen.sum()), int(picked.sum())
    return UsageRecord(
        episodes=episodes, steps=count, switches=int(switched.sum()) / episodes, share=_shares(steps.option[picked])
    )


def _binned(option: IntArray, distance: FloatArray, reach: float) -> tuple[UsageBinRecord, ...]:
    """Return the option usage by distance, in bins up to the sensor's ``reach``, and beyond it."""
    lows = np.arange(0.0, reach, BIN)
    place = np.searchsorted([*lows[1:], reach], distance, side="right")
    bounds = [*zip(lows.tolist(), [*lows[1:].tolist(), reach], strict=True), (reach, None)]
    return tuple(_bin(option[place == i], low, high) for i, (low, high) in enumerate(bounds))


def _bin(option: IntArray, low: float, high: float | None) -> UsageBinRecord:
    return UsageBinRecord(low=low, high=high, steps=len(option), share=_shares(option) if len(option) else None)


def _shares(option: IntArray) -> Shares:
    return {name: float((option == code).mean()) for name, code in OPTIONS.items()}
