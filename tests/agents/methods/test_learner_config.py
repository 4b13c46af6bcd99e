from typing import Any

import pytest

from hhrl_agents.methods.configs import LearnerConfig
from support.misuse import refused


@pytest.mark.parametrize(
    ("name", "value", "allowed"),
    [
        ("hidden", (), "one or more positive layer widths"),
        ("hidden", (64, 0), "one or more positive layer widths"),
        ("memory", (0.1, 0.0), "rates in (0, 1)"),
        ("memory", (1.0,), "rates in (0, 1)"),
        ("memory", (float("nan"),), "rates in (0, 1)"),
        ("n_envs", 0, "a whole number, at least 1"),
        ("report_every", 0, "a whole number, at least 1"),
        ("gamma", 1.5, "a number in [0, 1]"),
        ("gamma", float("nan"), "a number in [0, 1]"),
        ("jerk_weight", -0.1, "a number in [0, 1]"),
        ("jerk_weight", 1.1, "a number in [0, 1]"),
        ("reward_scale", 0.0, "a number above 0"),
        ("timeout", "maybe", "one of: truncation, terminal"),
    ],
)
def test_a_bad_value_is_named_in_one_line(name: str, value: Any, allowed: str) -> None:
    refused(lambda: LearnerConfig(**{name: value}), f"{name} is {value!r}; write {allowed}")


@pytest.mark.parametrize(("memory", "features"), [((), 11), ((0.5,), 22), ((0.1, 0.03), 33)])
def test_networks_read_the_state_and_as_much_for_each_trace(memory: tuple[float, ...], features: int) -> None:
    assert LearnerConfig(memory=memory).features == features


@pytest.mark.parametrize("name", ["gamma", "jerk_weight"])
@pytest.mark.parametrize("value", [0.0, 1.0])
def test_the_bounds_of_shares_are_allowed(name: str, value: float) -> None:
    values: dict[str, Any] = {name: value}
    assert getattr(LearnerConfig(**values), name) == value
