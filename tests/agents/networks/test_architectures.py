"""What the networks of the methods consist of."""

from dataclasses import replace

import pytest

from hhrl_agents import METHODS
from hhrl_agents.networks.architectures import Architecture, Attended, frozen_shapes, method_shapes
from hhrl_envs.observation import SIZE


def test_shapes_follow_the_sizes() -> None:
    assert Architecture(11, (8,), 3).shapes() == {
        "0.weight": (11, 8),
        "0.bias": (1, 8),
        "1.weight": (8, 3),
        "1.bias": (1, 3),
    }
    reading = Architecture(22, (5,), 3, reads_option=True, attended=Attended.LINEAR)
    assert list(reading.shapes().items()) == [
        ("values.0.weight", (24, 5)),
        ("values.0.bias", (1, 5)),
        ("values.1.weight", (5, 3)),
        ("values.1.bias", (1, 3)),
        ("attention.state.weight", (SIZE, SIZE)),
        ("attention.state.bias", (1, SIZE)),
        ("attention.option.weight", (2, SIZE)),
    ]


def layers(prefix: str, fan_in: int, fan_out: int) -> dict[str, tuple[int, int]]:
    shapes = {"0.weight": (fan_in, 7), "0.bias": (1, 7), "1.weight": (7, fan_out), "1.bias": (1, fan_out)}
    return {f"{prefix}.{name}": shape for name, shape in shapes.items()}


@pytest.mark.parametrize("name", METHODS)
def test_levels_of_the_methods(name: str) -> None:
    method = replace(METHODS[name], config=replace(METHODS[name].config, hidden=(7,)))
    features = SIZE * (1 + len(method.config.memory))
    expected: dict[str, tuple[int, int]] = {}
    if "option" in method.levels:
        expected |= layers("option", features, 2)
    if "action" in method.levels:
        expected |= layers("action.values", features + 2, 6) if method.hierarchical else layers("action", features, 6)
    if method.attention:
        expected["action.attention.state.weight"] = (SIZE, SIZE)
        expected["action.attention.state.bias"] = (1, SIZE)
        expected["action.attention.option.weight"] = (2, SIZE)
    assert list(method_shapes(method, 6).items()) == list(expected.items())


def test_a_frozen_follower_brings_its_own_shapes() -> None:
    follower = method_shapes(METHODS["follow-only"], 6)
    frozen = frozen_shapes(METHODS["option-only"], 6)
    assert frozen == {f"ffv.{name}": shape for name, shape in follower.items()}
    assert not frozen_shapes(METHODS["hybrid-hrl"], 6)
