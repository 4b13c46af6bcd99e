from dataclasses import replace
from typing import Any

import pytest

from hhrl_envs import SCENARIOS, Goal, InputError, Road, Scenario, Signal, UnknownScenarioError, Vehicle, get_scenario

MAIN = get_scenario("stop-line-v0")


def test_an_unknown_id_lists_the_known_ones_in_one_line() -> None:
    for look_up in (get_scenario, SCENARIOS.__getitem__):
        with pytest.raises(UnknownScenarioError) as caught:
            look_up("stop-line-v9")
        assert str(caught.value).startswith("unknown scenario 'stop-line-v9'; write one of: stop-line-v0, ")
    assert SCENARIOS.get("stop-line-v9") is None
    assert isinstance(caught.value, KeyError)


@pytest.mark.parametrize("scenario", SCENARIOS.values(), ids=str)
def test_a_registered_scenario_is_hashable_versioned_data(scenario: Scenario) -> None:
    assert hash(scenario) == hash(replace(scenario))
    assert scenario.id.rsplit("-", 1)[1].startswith("v")
    assert len(scenario.spec_hash) == 64


def test_hashes_follow_what_they_stand_for() -> None:
    other_world = replace(MAIN, horizon=500)
    assert other_world.spec_hash != MAIN.spec_hash
    assert other_world.interface_hash == MAIN.interface_hash
    other_levels = replace(MAIN, vehicle=Vehicle(levels=(-3.0, 2.0)))
    assert other_levels.interface_hash != MAIN.interface_hash


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"road": Road(lines=())}, "lines"),
        ({"goal": Goal.FOLLOW}, "lines"),
        ({"goal": Goal.FOLLOW, "road": Road(lines=())}, "count_shares"),
        ({"signal": Signal((1.0, 2.0))}, "signal"),
        ({"dt": 0.0}, "dt"),
        ({"horizon": 0}, "horizon"),
    ],
)
def test_contradictions_are_named(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        replace(MAIN, **changes)
