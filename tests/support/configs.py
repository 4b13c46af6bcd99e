"""Methods of every algorithm with the same small hyperparameters, as far as the algorithm has them."""

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any

from hhrl_agents import METHODS
from hhrl_agents.methods.method import Method


def with_values(method: Method, values: Mapping[str, Any]) -> Method:
    """Return the method with those of `values` in its config that the config's class has."""
    own = {field.name for field in fields(method.config)}
    return replace(method, config=replace(method.config, **{name: values[name] for name in values if name in own}))


def small_methods(values: Mapping[str, Any]) -> dict[str, Method]:
    """Return every registered method, by its id, with those of `values` that it knows."""
    return {name: with_values(method, values) for name, method in METHODS.items()}
