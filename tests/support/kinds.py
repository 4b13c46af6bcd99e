"""A small method of every kind of network, with parameters drawn at random."""

from dataclasses import replace
from typing import Any

import numpy as np

from hhrl_agents import METHODS
from hhrl_agents.methods.method import Method
from hhrl_agents.networks.architectures import frozen_shapes, method_shapes
from hhrl_envs import Scenario
from hhrl_envs.arrays import Floats32

KINDS: dict[str, tuple[str, dict[str, Any]]] = {
    "flat": ("ddqn", {}),
    "flat-layer-norm-memory": ("ddqn", {"layer_norm": True, "memory": (0.1,), "advantage_learning": 0.9}),
    "no-attention": ("hrl-2", {}),
    "attention": ("hybrid-hrl", {}),
    "figure-2": ("hybrid-hrl-figure-2", {}),
    "layer-norm": ("hybrid-hrl", {"layer_norm": True}),
    "memory": ("hybrid-hrl-plus", {}),
    "blind": ("hybrid-hrl", {"sees_line": False, "memory": (0.1, 0.03)}),
    "follow-only": ("follow-only", {}),
    "option-only": ("option-only", {}),
    "rule-option": ("rule-option", {}),
}
"""What the test calls it -> the registered method, and what is changed of its config."""


def method_of(kind: str) -> Method:
    """Return the small method of a kind."""
    name, changes = KINDS[kind]
    method = METHODS[name]
    return replace(method, config=replace(method.config, hidden=(16, 12), **changes))


def parameters_of(method: Method, scenario: Scenario, seed: int) -> dict[str, Floats32]:
    """Return parameters as a checkpoint has them, normal with standard deviation 0.4."""
    rng = np.random.default_rng(seed)
    shapes = method_shapes(method, scenario.num_actions) | frozen_shapes(method, scenario.num_actions)
    return {name: rng.normal(0.0, 0.4, (1, *shape)).astype(np.float32) for name, shape in shapes.items()}
