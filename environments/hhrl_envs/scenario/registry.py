"""The registered scenarios. Every list of scenarios anywhere is derived from ``SCENARIOS``."""

import operator
from collections.abc import Mapping
from math import inf
from types import MappingProxyType

from hhrl_envs.errors import InputError, UnknownScenarioError, require_value
from hhrl_envs.scenario.scenario import Scenario
from hhrl_envs.scenario.validation import is_integer


class _ById(dict[str, Scenario]):
    def __missing__(self, scenario_id: str) -> Scenario:
        raise UnknownScenarioError(f"unknown scenario {scenario_id!r}; write one of: {', '.join(self)}")


_by_id = _ById()
_places: dict[str, float] = {}
_summaries: dict[str, str] = {}
_successors: dict[str, str] = {}

SCENARIOS: Mapping[str, Scenario] = MappingProxyType(_by_id)
"""Every registered scenario by its id; an unknown id raises ``UnknownScenarioError`` that lists the known ones."""

SUMMARIES: Mapping[str, str] = MappingProxyType(_summaries)
"""What is special in the registered scenarios, in a few words, by their ids; empty where nobody has said it."""

SUPERSEDED: Mapping[str, str] = MappingProxyType(_successors)
"""The registered scenarios that are kept for old results only, and the one to use in place of each, by their ids."""


def add_scenario(scenario: Scenario, place: float = inf, summary: str = "", superseded_by: str | None = None) -> None:
    """Register a scenario at a ``place`` in the order of all lists, by default behind those that are there.

    An equal one that is there already stays. The ``summary`` says in a few words what is special. One that is kept for
    old results only is ``superseded_by`` another, whose id that is.

    Raises:
        InputError: if another scenario has its id.
    """
    if _by_id.get(scenario.id, scenario) != scenario:
        raise InputError(f"there is a scenario {scenario.id!r} already; write another id, such as 'my-road-v0'")
    if scenario.id in _by_id:
        return
    _places[scenario.id] = place
    _summaries[scenario.id] = summary
    if superseded_by is not None:
        _successors[scenario.id] = superseded_by
    known = sorted([*_by_id.values(), scenario], key=lambda one: _places[one.id])
    _by_id.clear()
    _by_id.update((one.id, one) for one in known)


def get_scenario(scenario_id: str) -> Scenario:
    """Return the registered scenario; raises ``UnknownScenarioError`` that lists the known ids."""
    return SCENARIOS[scenario_id]


def as_scenario(scenario: Scenario | str) -> Scenario:
    """Return the scenario itself, or the registered one of that id."""
    if isinstance(scenario, str):
        return get_scenario(scenario)
    allowed = "a registered id, such as 'stop-line-v0', or a Scenario"
    require_value(isinstance(scenario, Scenario), "scenario", repr(scenario), allowed)
    return scenario


def as_count(count: int, name: str) -> int:
    """Return the count as an int; raise an ``InputError`` unless it is an integer of at least 1."""
    require_value(is_integer(count) and count >= 1, name, repr(count), "an integer, at least 1")
    return operator.index(count)


def as_learned_fronts(count: int | None, scenario: Scenario) -> int:
    """Return how many front vehicles are agents: the scenario's own number where it is None."""
    if count is None:
        return scenario.learned_fronts or 0
    scenario.require_fronts(count)
    return operator.index(count)
