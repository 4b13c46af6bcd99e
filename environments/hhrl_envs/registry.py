"""The registered scenarios. Every list of scenarios anywhere is derived from ``SCENARIOS``."""

from collections.abc import Mapping
from types import MappingProxyType

from hhrl_envs.errors import UnknownScenarioError
from hhrl_envs.profiles import TRAIN_FAMILIES
from hhrl_envs.scenario import Scenario, Traffic

_ALL = (Scenario(id="stop-line-v0", traffic=Traffic(families=TRAIN_FAMILIES)),)

SCENARIOS: Mapping[str, Scenario] = MappingProxyType({scenario.id: scenario for scenario in _ALL})
"""Every registered scenario by its id."""


def get_scenario(scenario_id: str) -> Scenario:
    """Return the registered scenario; raises ``UnknownScenarioError`` that lists the known ids."""
    if scenario_id not in SCENARIOS:
        raise UnknownScenarioError(f"unknown scenario {scenario_id!r}; write one of: {', '.join(SCENARIOS)}")
    return SCENARIOS[scenario_id]
