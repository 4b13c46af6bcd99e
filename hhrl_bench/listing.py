"""What is registered, as rows to list: agents, tasks and suites."""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from hhrl_agents import METHODS, RULES
from hhrl_bench import suite
from hhrl_bench.loading import shipped_methods
from hhrl_bench.tasks import TASKS

Rows = list[dict[str, Any]]


def agents() -> Rows:
    """Return the rule agents, and the learned methods: how many trained seeds come with the package, what they are."""
    shipped = shipped_methods()
    rules = [{"id": name, "kind": "rule", "shipped_seeds": None, "summary": None} for name in RULES]
    learned = [
        {"id": name, "kind": "learned", "shipped_seeds": shipped.get(name, 0), "summary": method.summary}
        for name, method in METHODS.items()
    ]
    return [*rules, *learned]


def tasks() -> Rows:
    """Return the tasks: scenario, training budget, what a scored agent drives behind whom, first and last seeds."""
    return [
        {
            "id": task.id,
            "scenario": task.scenario,
            "env_steps": task.env_steps,
            "drives": "all" if task.shared else "ego",
            "opponent": task.opponent,
            **{
                f"{seeds.name}_seeds": [seeds.start, seeds.start + seeds.size - 1]
                for seeds in (task.train, task.validation, task.test)
            },
        }
        for task in TASKS.values()
    ]


def suites() -> Rows:
    """Return the suites: their tasks, agents and number of episodes."""
    return [
        {"id": one.id, "tasks": list(one.tasks), "agents": list(one.agents), "episodes": one.episodes}
        for one in suite.SUITES.values()
    ]


LISTS: Mapping[str, Callable[[], Rows]] = MappingProxyType({"agents": agents, "tasks": tasks, "suites": suites})
"""Each list by the name that the command line has for it."""
