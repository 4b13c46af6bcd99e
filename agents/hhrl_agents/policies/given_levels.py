"""Levels that are given, not learned: options by a rule, actions by one policy for each sub-goal."""

from collections.abc import Callable

import numpy as np

from hhrl_agents.agent import HierarchicalAgent
from hhrl_agents.methods.method import Method
from hhrl_agents.rules.paper_rules import PAPER_RULES, rule_2
from hhrl_envs import Option, Scenario
from hhrl_envs.arrays import Floats32, Ints
from hhrl_envs.observation import SIZE

Options = Callable[[Floats32], Ints]
"""Options int64 [B] for what networks read, float32 [B, features], the observation first."""

Actions = Callable[[Floats32, Ints], Ints]
"""Actions int64 [B] for what networks read, float32 [B, features], and options int64 [B]."""


def given_options(method: Method, scenario: Scenario) -> Options:
    """Return the option level of the method's rule; rules remember nothing, so the state alone decides."""
    rule = PAPER_RULES[method.option](scenario)
    return lambda features: rule.select(features[:, :SIZE])


def given_actions(scenario: Scenario, ffv: HierarchicalAgent) -> Actions:
    """Return the action level that stops with the analytic controller and follows with the policy `ffv`."""
    stop = rule_2(scenario)

    def act(features: Floats32, option: Ints) -> Ints:
        observations = features[:, :SIZE]
        following = ffv.act_with_option(observations, np.full_like(option, Option.FFV))
        return np.where(option == Option.FFV, following, stop.act_with_option(observations, option))

    return act
