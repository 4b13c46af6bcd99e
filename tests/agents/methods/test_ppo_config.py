from typing import Any

import pytest

from hhrl_agents.methods.configs import PPOConfig
from hhrl_envs import InputError


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("hidden", ()),
        ("hidden", (64, 0)),
        ("n_envs", 0),
        ("rollout_steps", 0),
        ("epochs", 0),
        ("batch_size", 1),
        ("batch_size", 100),
        ("learning_rate", 0.0),
        ("final_learning_rate", -1.0),
        ("max_gradient_norm", 0.0),
        ("gamma", 1.5),
        ("jerk_weight", -0.5),
        ("layer_norm", True),
        ("memory", (0.1,)),
        ("gae_lambda", float("nan")),
        ("clip", 0.0),
        ("entropy_coefficient", -0.1),
        ("value_coefficient", float("nan")),
        ("reward_scale", 0.0),
        ("throttle_bias", float("inf")),
        ("timeout", "maybe"),
        ("report_every", 0),
    ],
)
def test_a_bad_value_is_named_in_one_line(name: str, value: Any) -> None:
    with pytest.raises(InputError, match=rf"{name} is .*; write ") as error:
        PPOConfig(**{name: value})
    assert "\n" not in str(error.value)
