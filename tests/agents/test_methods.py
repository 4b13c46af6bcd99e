import json
from dataclasses import replace
from typing import Any

import pytest

from hhrl_agents import METHODS
from hhrl_agents.methods import LearnerConfig, Method
from hhrl_envs import InputError


def test_the_paper_s_table_of_switches() -> None:
    switches = {
        name: (method.hybrid_reward, method.hierarchical_per, method.attention)
        for name, method in METHODS.items()
        if method.hierarchical
    }
    assert switches == {
        "hrl-0": (False, False, False),
        "hrl-1": (True, False, False),
        "hrl-2": (True, True, False),
        "hrl-3": (True, False, True),
        "hybrid-hrl": (True, True, True),
    }
    assert not METHODS["ddqn"].hierarchical
    assert {name for name, method in METHODS.items() if method.algorithm != "double-dqn"} == {"pqn"}


@pytest.mark.parametrize("name", METHODS)
def test_a_method_survives_json(name: str) -> None:
    method = METHODS[name]
    assert method.id == name
    assert Method.from_data(name, json.loads(json.dumps(method.data()))) == method


def test_the_config_hash_follows_every_value_but_the_id() -> None:
    method = METHODS["hybrid-hrl"]
    others = [
        replace(method, attention=False),
        replace(method, config=replace(method.config, gamma=0.9)),
        replace(method, config=replace(method.config, hidden=(64,))),
    ]
    assert len({method.config_hash, *(other.config_hash for other in others)}) == 4
    assert replace(method, id="other").config_hash == method.config_hash


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("gamma", 1.5),
        ("gamma", float("nan")),
        ("batch_size", 0),
        ("hidden", ()),
        ("hidden", (64, 0)),
        ("learning_rate", 0.0),
        ("final_epsilon", -0.1),
        ("exploration_share", 0.0),
        ("priority_floor", 0.0),
        ("timeout", "maybe"),
        ("priority", "none"),
        ("warmup", 1),
        ("replay_capacity", 10),
        ("exploration_hold", 0),
    ],
)
def test_a_bad_value_is_named_in_one_line(name: str, value: Any) -> None:
    with pytest.raises(InputError, match=rf"{name} is .*; write ") as error:
        LearnerConfig(**{name: value})
    assert "\n" not in str(error.value)


def test_a_flat_method_has_no_switches() -> None:
    with pytest.raises(InputError, match="hierarchical=True"):
        Method("flat", attention=True)


def test_an_algorithm_has_its_own_config_and_only_double_dqn_a_hierarchy() -> None:
    with pytest.raises(InputError, match=r"config is .*; write PQNConfig\(...\)"):
        Method("pqn", algorithm="pqn")
    with pytest.raises(InputError, match="algorithm='double-dqn'"):
        replace(METHODS["pqn"], hierarchical=True)
    with pytest.raises(InputError, match=r"algorithm is 'sarsa'; write one of: double-dqn, pqn"):
        replace(METHODS["pqn"], algorithm="sarsa")  # type: ignore[arg-type]


def test_unknown_entries_are_refused() -> None:
    data = METHODS["ddqn"].data()
    with pytest.raises(InputError, match="unknown"):
        Method.from_data("ddqn", {**data, "unknown": 1})
    with pytest.raises(InputError, match="unknown"):
        Method.from_data("ddqn", {**data, "config": {**data["config"], "unknown": 1}})
    with pytest.raises(InputError, match="config"):
        Method.from_data("ddqn", {})
