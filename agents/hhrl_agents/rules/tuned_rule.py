"""The rule whose numbers a search has found, for every task by itself, or for all of them at once.

The numbers are data beside this file. They are made anew by

    hhrl-bench tune rule-tuned --out agents/hhrl_agents/rules/rule-tuned.json
    hhrl-bench tune rule-robust --out agents/hhrl_agents/rules/rule-robust.json
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import MappingProxyType

from hhrl_agents.agent import HierarchicalAgent
from hhrl_agents.rules.rule_plus import RulePlus
from hhrl_agents.rules.tuning import FIRST_TUNING, Tuning
from hhrl_envs import Scenario

TUNED, ROBUST = "rule-tuned", "rule-robust"

ALL_TASKS = "all"
"""The name of the set of numbers that is for all tasks; the others are called like their scenario."""

HELD_OUT: Mapping[str, str] = MappingProxyType({"stop-line-heldout-v0": "stop-line-v0"})
"""Scenarios whose drivers nobody is to have met before, and those whose numbers are taken there, as learners' are."""


def stored(rule: str) -> Path:
    """Return the file that holds the sets of numbers of one of the two rules."""
    return Path(__file__).with_name(f"{rule}.json")


@cache
def tunings(rule: str) -> Mapping[str, Tuning]:
    """Return the sets of numbers of one of the two rules by their names."""
    sets = json.loads(stored(rule).read_text(encoding="utf-8"))["sets"]
    return {name: replace(FIRST_TUNING, **found["tuning"]) for name, found in sets.items()}


def rule_robust(scenario: Scenario) -> RulePlus:
    """Return the agent that drives by the same numbers everywhere."""
    return RulePlus(scenario, tunings(ROBUST)[ALL_TASKS])


def rule_tuned(scenario: Scenario) -> RulePlus:
    """Return the agent that drives by the numbers found for this scenario; where there are none, the robust one."""
    found = tunings(TUNED).get(HELD_OUT.get(scenario.id, scenario.id))
    return rule_robust(scenario) if found is None else RulePlus(scenario, found)


RULES: Mapping[str, Callable[[Scenario], HierarchicalAgent]] = MappingProxyType(
    {TUNED: rule_tuned, ROBUST: rule_robust}
)
