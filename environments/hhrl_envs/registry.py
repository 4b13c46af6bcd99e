"""The registered scenarios. Every list of scenarios anywhere is derived from ``SCENARIOS``."""

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

from hhrl_envs.errors import UnknownScenarioError
from hhrl_envs.goals import Goal
from hhrl_envs.paper_scenario import STOP_LINE_PAPER
from hhrl_envs.profiles import HELD_OUT_FAMILIES, TRAIN_FAMILIES, ProfileFamily
from hhrl_envs.scenario import Adversary, Road, Scenario, Signal, Traffic
from hhrl_envs.tiers import TIERS

_MAIN = Scenario(id="stop-line-v0", traffic=Traffic(families=TRAIN_FAMILIES))

_JAM = (
    ProfileFamily(
        "stop-and-go",
        1.0,
        desired_speed=(5.0, 9.0),
        headway=(1.0, 1.6),
        max_accel=(1.0, 2.0),
        comfort_decel=(2.0, 3.5),
        line_decel=(2.0, 3.4),
        dwell=(0.5, 2.0),
        slow_at=(40.0, 70.0),
        slow_decel=(2.5, 4.0),
        slow_time=(2.0, 3.5),
        slow_every=(12.0, 20.0),
        slow_chance=1.0,
    ),
)

_CAUTIOUS = tuple(replace(family, line_decel=(1.2, 2.2), styles=(1.0, 0.0, 0.0)) for family in TRAIN_FAMILIES[:2])

_ALL = (
    _MAIN,
    STOP_LINE_PAPER,
    replace(_MAIN, id="stop-line-heldout-v0", traffic=Traffic(families=HELD_OUT_FAMILIES)),
    *TIERS,
    replace(
        _MAIN,
        id="follow-v0",
        traffic=Traffic(families=_JAM + TRAIN_FAMILIES[:2], count_shares=(0, 0.4, 0.4, 0.2)),
        road=Road(lines=()),
        goal=Goal.FOLLOW,
        horizon=400,
    ),
    replace(_MAIN, id="solo-stop-v0", traffic=Traffic(families=TRAIN_FAMILIES, count_shares=(1.0,))),
    replace(_MAIN, id="red-light-v0", goal=Goal.PASS, signal=Signal(green_at=(5.0, 30.0))),
    replace(_MAIN, id="stop-and-go-v0", traffic=Traffic(families=_JAM, count_shares=(0, 0.3, 0.4, 0.3)), horizon=900),
    replace(
        _MAIN,
        id="two-stops-v0",
        traffic=Traffic(families=_CAUTIOUS, count_shares=(0.2, 0.4, 0.4)),
        road=Road(lines=(0.0, 60.0)),
        horizon=1200,
    ),
    replace(
        _MAIN,
        id="platoon-v0",
        traffic=Traffic(families=TRAIN_FAMILIES, count_shares=(0, 0, 0, 0.6, 0.4), gap=(10.0, 25.0)),
        horizon=1200,
        feasible_only=False,
        learned_fronts=3,
    ),
    replace(
        _MAIN,
        id="adversary-v0",
        traffic=Traffic(families=TRAIN_FAMILIES, count_shares=(0, 0.5, 0.3, 0.2), gap=(12.0, 25.0)),
        feasible_only=False,
        learned_fronts=1,
        adversary=Adversary(),
    ),
)


class _ById(dict[str, Scenario]):
    def __missing__(self, scenario_id: str) -> Scenario:
        raise UnknownScenarioError(f"unknown scenario {scenario_id!r}; write one of: {', '.join(self)}")


SCENARIOS: Mapping[str, Scenario] = MappingProxyType(_ById((scenario.id, scenario) for scenario in _ALL))
"""Every registered scenario by its id; an unknown id raises ``UnknownScenarioError`` that lists the known ones."""


def get_scenario(scenario_id: str) -> Scenario:
    """Return the registered scenario; raises ``UnknownScenarioError`` that lists the known ids."""
    return SCENARIOS[scenario_id]
