from typing import Any

import pytest

from hhrl_agents.methods.configs import DoubleDQNConfig
from support.misuse import refused


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("gamma", 1.5),
        ("gamma", float("nan")),
        ("jerk_weight", 2.0),
        ("memory", (0.0,)),
        ("batch_size", 0),
        ("steps_per_update", 0),
        ("hidden", ()),
        ("hidden", (64, 0)),
        ("learning_rate", 0.0),
        ("final_learning_rate", 0.0),
        ("max_gradient_norm", 0.0),
        ("final_epsilon", -0.1),
        ("exploration_share", 0.0),
        ("priority_floor", 0.0),
        ("priority_exponent", 1.5),
        ("importance_exponent", -0.5),
        ("timeout", "maybe"),
        ("priority", "none"),
        ("attended", "both"),
        ("credit", "algorithm-3"),
        ("target_rate", 0.0),
        ("target_rate", 1.1),
        ("target_interval", 0),
        ("n_steps", 0),
        ("advantage_learning", -0.1),
        ("advantage_learning", 1.0),
        ("advantage_learning", float("nan")),
        ("warmup", 1),
        ("replay_capacity", 10),
        ("exploration_hold", 0),
    ],
)
def test_a_bad_value_is_named_in_one_line(name: str, value: Any) -> None:
    refused(lambda: DoubleDQNConfig(**{name: value}), f"{name} is {value!r}; write ")


def test_the_warmup_lasts_until_the_first_joined_steps_are_stored() -> None:
    assert DoubleDQNConfig(n_envs=32, n_steps=3, warmup=96).n_steps == 3
    refused(lambda: DoubleDQNConfig(n_envs=32, n_steps=3, warmup=95), "at least n_steps x n_envs (96)")


def test_all_of_the_warmup_is_kept() -> None:
    assert DoubleDQNConfig(warmup=500, replay_capacity=500).replay_capacity == 500
    refused(lambda: DoubleDQNConfig(warmup=500, replay_capacity=499), "at least warmup (500)")


def test_the_linear_layer_attends_without_memory_alone() -> None:
    assert DoubleDQNConfig(memory=(0.1,)).attended == "state"
    assert DoubleDQNConfig(attended="linear").memory == ()
    refused(lambda: DoubleDQNConfig(attended="linear", memory=(0.1,)), "attended is 'linear'; write state, where")
