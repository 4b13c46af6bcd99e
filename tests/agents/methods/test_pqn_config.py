from typing import Any

import pytest

from hhrl_agents.methods.configs import PQNConfig
from hhrl_envs import InputError


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("hidden", ()),
        ("hidden", (64, 0)),
        ("n_envs", 0),
        ("rollout_steps", 0),
        ("epochs", 0),
        ("minibatches", 0),
        ("minibatches", 7),
        ("trace_decay", 1.5),
        ("learning_rate", 0.0),
        ("final_learning_rate", -1.0),
        ("max_gradient_norm", 0.0),
        ("gamma", float("nan")),
        ("jerk_weight", 1.5),
        ("memory", (1.0,)),
        ("reward_scale", 0.0),
        ("exploration_share", 0.0),
        ("final_epsilon", -0.1),
        ("exploration_hold", 0),
        ("timeout", "maybe"),
        ("report_every", 0),
    ],
)
def test_a_bad_value_is_named_in_one_line(name: str, value: Any) -> None:
    with pytest.raises(InputError, match=rf"{name} is .*; write ") as error:
        PQNConfig(**{name: value})
    assert "\n" not in str(error.value)
