import hashlib
import json
from dataclasses import asdict, replace
from typing import Any

import pytest

from hhrl_envs import (
    SCENARIOS,
    Ghosts,
    Goal,
    InputError,
    Road,
    Scenario,
    Sensor,
    Signal,
    Slippery,
    UnknownScenarioError,
    Vehicle,
    get_scenario,
)

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


def test_an_addition_counts_in_the_hash_only_where_it_is_used() -> None:
    """Fields that scenarios did not always have leave the hash of every scenario without them as it was."""
    before = {name: value for name, value in asdict(MAIN).items() if value is not None}
    for part, additions in {
        "reward": ["unsafe"],
        "sensor": ["dropout", "dropout_time", "ghosts"],
        "road": ["slippery"],
    }.items():
        for addition in additions:
            del before[part][addition]
    stored = json.dumps(before, sort_keys=True)
    assert MAIN.spec_hash == hashlib.sha256(stored.encode()).hexdigest()
    printed = replace(MAIN, reward=replace(MAIN.reward, unsafe="printed"))
    flickering = replace(MAIN, sensor=Sensor(dropout=0.5))
    slower = replace(MAIN, sensor=Sensor(dropout=0.5, dropout_time=2.0))
    slippery = replace(MAIN, road=Road(slippery=Slippery(0.5, (0.1, 0.3))))
    haunted = replace(MAIN, sensor=Sensor(ghosts=Ghosts(0.5)))
    nearer = replace(MAIN, sensor=Sensor(ghosts=Ghosts(0.5, near=4.0)))
    others = haunted, nearer, printed, flickering, slower, slippery, replace(MAIN, learned_fronts=1)
    assert len({MAIN.spec_hash, *(other.spec_hash for other in others)}) == 1 + len(others)
    assert replace(printed, reward=MAIN.reward).spec_hash == MAIN.spec_hash


@pytest.mark.parametrize(
    ("scenario_id", "spec_hash"),
    [
        ("stop-line-v0", "b0da6528c41afebc5c00449e5190d9cc95757514228eccff32a527e63543f2b9"),
        ("red-light-v0", "6a0a2356a1ff77b4113f14ad7daf6e4b907d5e497bcba1870129e136eb82ed9c"),
        ("adversary-v0", "780deb577655ffd0bf59b6076bfe27911db15e403efd04272a3fb1d08e935aab"),
    ],
)
def test_hashes_stay_what_they_were(scenario_id: str, spec_hash: str) -> None:
    """Checkpoints and published entries hold them."""
    assert SCENARIOS[scenario_id].spec_hash == spec_hash


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
