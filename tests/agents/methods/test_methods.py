import json
from dataclasses import replace
from typing import Any

import pytest

from hhrl_agents import METHODS
from hhrl_agents.methods.configs import DoubleDQNConfig
from hhrl_agents.methods.method import Method
from hhrl_envs import InputError


def test_the_paper_s_table_of_switches() -> None:
    names = ("ddqn", "hrl-0", "hrl-1", "hrl-2", "hrl-3", "hybrid-hrl")
    methods = {name: METHODS[name] for name in names}
    assert {name: (m.option, m.hybrid_reward, m.replay, m.attention) for name, m in methods.items()} == {
        "ddqn": ("none", False, "uniform", False),
        "hrl-0": ("learned", False, "uniform", False),
        "hrl-1": ("learned", True, "uniform", False),
        "hrl-2": ("learned", True, "hierarchical", False),
        "hrl-3": ("learned", True, "uniform", True),
        "hybrid-hrl": ("learned", True, "hierarchical", True),
    }
    assert all(method.config == DoubleDQNConfig() and method.ffv is None for method in methods.values())


def test_options_are_learned_held_by_a_rule_or_absent() -> None:
    given = {name: method.option for name, method in METHODS.items() if method.option != "learned"}
    assert given == {
        **dict.fromkeys(("ddqn", "ddqn-plus", "ddqn-per", "pqn", "ppo", "adversary"), "none"),
        "follow-only": "rule-1",
        "rule-option": "rule-4",
    }
    assert {name for name, method in METHODS.items() if not method.hierarchical} == {
        name for name, option in given.items() if option == "none"
    }
    assert {name: method.ffv.id for name, method in METHODS.items() if method.ffv} == {"option-only": "follow-only"}
    assert {name for name, method in METHODS.items() if method.algorithm != "double-dqn"} == {"ppo", "pqn"}


@pytest.mark.parametrize(
    ("option", "ffv", "levels"),
    [
        ("none", None, ("action",)),
        ("learned", None, ("option", "action")),
        ("learned", METHODS["follow-only"], ("option",)),
        ("rule-4", None, ("action",)),
    ],
)
def test_levels_are_what_is_learned(option: str, ffv: Method | None, levels: tuple[str, ...]) -> None:
    assert Method("x", option=option, ffv=ffv).levels == levels


def test_the_plus_methods_differ_from_their_base_in_the_same_values_alone() -> None:
    hierarchical, flat = METHODS["hybrid-hrl-plus"], METHODS["ddqn-plus"]
    assert hierarchical.config == flat.config != DoubleDQNConfig()
    assert replace(hierarchical, id="hybrid-hrl", config=DoubleDQNConfig()) == METHODS["hybrid-hrl"]
    assert replace(flat, id="ddqn", config=DoubleDQNConfig()) == METHODS["ddqn"]


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
    ("switch", "complaint"),
    [
        ({"attention": True}, "option of method 'flat' is 'none'; write 'learned' or a rule's id to use ffv,"),
        ({"hybrid_reward": True}, "option of method 'flat' is 'none'; write 'learned' or a rule's id to use ffv,"),
        ({"replay": "hierarchical"}, "replay of method 'flat' is 'hierarchical'; write uniform or prioritised, as"),
    ],
)
def test_a_flat_method_has_no_switches(switch: dict[str, Any], complaint: str) -> None:
    with pytest.raises(InputError, match=complaint) as error:
        Method("flat", **switch)
    assert "\n" not in str(error.value)


def test_a_flat_method_may_have_plain_prioritised_replay() -> None:
    assert Method("flat", replay="prioritised").replay == "prioritised"


def test_an_unknown_replay_is_refused() -> None:
    with pytest.raises(InputError, match="write one of: uniform, prioritised, hierarchical"):
        Method.from_data("other", {**METHODS["hybrid-hrl"].data(), "replay": "random"})


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
