import json
from dataclasses import replace
from typing import Any

import pytest

from hhrl_agents import METHODS
from hhrl_agents.double_dqn_config import DoubleDQNConfig
from hhrl_agents.methods import Method
from hhrl_envs import InputError


def test_the_paper_s_table_of_switches() -> None:
    switches = {
        name: (method.hybrid_reward, method.replay, method.attention)
        for name, method in METHODS.items()
        if method.hierarchical
    }
    assert switches == {
        "hrl-0": (False, "uniform", False),
        "hrl-1": (True, "uniform", False),
        "hrl-2": (True, "hierarchical", False),
        "hrl-3": (True, "uniform", True),
        "hybrid-hrl": (True, "hierarchical", True),
    }
    assert not METHODS["ddqn"].hierarchical
    assert {name for name, method in METHODS.items() if method.algorithm != "double-dqn"} == {"ppo", "pqn"}
    assert METHODS["ddqn"].replay == "uniform"


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
        replace(method, replay="prioritised"),
        replace(method, config=replace(method.config, attended="linear")),
    ]
    assert len({method.config_hash, *(other.config_hash for other in others)}) == 6
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
        ("attended", "both"),
        ("credit", "algorithm-3"),
        ("target_rate", 0.0),
        ("target_rate", 1.1),
        ("target_interval", 0),
        ("n_steps", 0),
        ("warmup", 1),
        ("replay_capacity", 10),
        ("exploration_hold", 0),
    ],
)
def test_a_bad_value_is_named_in_one_line(name: str, value: Any) -> None:
    with pytest.raises(InputError, match=rf"{name} is .*; write ") as error:
        DoubleDQNConfig(**{name: value})
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("switch", [{"attention": True}, {"hybrid_reward": True}, {"replay": "hierarchical"}])
def test_a_flat_method_has_no_switches(switch: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="hierarchical=True"):
        Method("flat", **switch)


def test_a_flat_method_may_have_plain_prioritised_replay() -> None:
    assert Method("flat", replay="prioritised").replay == "prioritised"


def test_an_unknown_replay_is_refused() -> None:
    with pytest.raises(InputError, match="write uniform, prioritised or hierarchical"):
        Method.from_data("other", {**METHODS["hybrid-hrl"].data(), "replay": "random"})


def test_the_warmup_lasts_until_the_first_joined_steps_are_stored() -> None:
    assert DoubleDQNConfig(n_envs=32, n_steps=3, warmup=96).n_steps == 3
    with pytest.raises(InputError, match=r"at least n_steps x n_envs \(96\)"):
        DoubleDQNConfig(n_envs=32, n_steps=3, warmup=95)


@pytest.mark.parametrize(
    "reading",
    [
        {"timeout": "terminal"},
        {"priority": "shift"},
        {"attended": "linear"},
        {"credit": "algorithm-2"},
        {"target_interval": 1, "target_rate": 1.0},
    ],
)
def test_the_literal_readings_are_settings(reading: dict[str, Any]) -> None:
    method = replace(METHODS["hybrid-hrl"], config=DoubleDQNConfig(**reading))
    assert Method.from_data("literal", json.loads(json.dumps(method.data()))).config == method.config
    assert method.config_hash != METHODS["hybrid-hrl"].config_hash


def test_an_algorithm_has_its_own_config_and_only_double_dqn_a_hierarchy() -> None:
    with pytest.raises(InputError, match=r"config of method 'ppo' is 3; write one of: DoubleDQNConfig, PQNConfig"):
        Method("ppo", config=3)
    with pytest.raises(InputError, match="write a DoubleDQNConfig to have options"):
        replace(METHODS["ppo"], option="learned")


def test_unknown_entries_are_refused() -> None:
    data = METHODS["ddqn"].data()
    with pytest.raises(InputError, match="unknown"):
        Method.from_data("ddqn", {**data, "unknown": 1})
    with pytest.raises(InputError, match="unknown"):
        Method.from_data("ddqn", {**data, "config": {**data["config"], "unknown": 1}})
    with pytest.raises(InputError, match="config"):
        Method.from_data("ddqn", {})


@pytest.mark.parametrize("name", ["target_rate", "attended", "n_steps"])
def test_missing_entries_are_refused(name: str) -> None:
    data = METHODS["ddqn"].data()
    config = {key: value for key, value in data["config"].items() if key != name}
    with pytest.raises(InputError, match=f"missing {name}"):
        Method.from_data("ddqn", {**data, "config": config})
    with pytest.raises(InputError, match="missing replay"):
        Method.from_data("ddqn", {key: value for key, value in data.items() if key != "replay"})
