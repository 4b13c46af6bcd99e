"""What the value networks of a method consist of, and the shapes of their parameters; Figure 2 of the paper."""

from collections.abc import Mapping
from enum import IntEnum
from itertools import pairwise
from typing import NamedTuple

from hhrl_agents.methods.method import Method
from hhrl_envs import SUB_GOALS
from hhrl_envs.arrays import Floats32
from hhrl_envs.observation import SIZE

NUM_OPTIONS = len(SUB_GOALS)

FROZEN = "ffv."
"""What the names of the parameters begin with that a method uses without learning them: its FFV policy's."""

Shapes = dict[str, tuple[int, int]]

Parameters = Mapping[str, Floats32]
"""The parameters of networks by name, float32 [1, in, out] each."""


class Attended(IntEnum):
    """What the attention multiplies: there is none, the state, or the linear layer of it (Figure 2)."""

    NOTHING = 0
    STATE = 1
    LINEAR = 2


class Architecture(NamedTuple):
    """What a value network consists of.

    features: numbers that it reads of a state; hidden: units of its hidden layers; outputs: its values; reads_option:
    whether it reads a one-hot option too; attended: what its attention multiplies; layer_norm: normalise what enters
    every ReLU to mean 0 and variance 1 over the units of the layer; sees_line: whether it reads the state elements of
    the stop-line, which are 0 otherwise.
    """

    features: int
    hidden: tuple[int, ...]
    outputs: int
    reads_option: bool = False
    attended: Attended = Attended.NOTHING
    layer_norm: bool = False
    sees_line: bool = True

    @property
    def sizes(self) -> tuple[int, ...]:
        """The units of all layers, the inputs first."""
        return (self.features + NUM_OPTIONS * self.reads_option, *self.hidden, self.outputs)

    def shapes(self) -> Shapes:
        """Return the parameter shapes, in the order in which they lie."""
        prefix, shapes = "values." if self.reads_option else "", Shapes()
        for layer, (fan_in, fan_out) in enumerate(pairwise(self.sizes)):
            shapes[f"{prefix}{layer}.weight"] = (fan_in, fan_out)
            shapes[f"{prefix}{layer}.bias"] = (1, fan_out)
        if self.attended:
            shapes["attention.state.weight"] = (SIZE, SIZE)
            shapes["attention.state.bias"] = (1, SIZE)
            shapes["attention.option.weight"] = (NUM_OPTIONS, SIZE)
        return shapes


def architectures(method: Method, num_actions: int) -> dict[str, Architecture]:
    """Return the network of each of the method's learned levels, by the level's name."""
    config = method.config
    option = Architecture(config.features, config.hidden, NUM_OPTIONS, layer_norm=config.layer_norm)
    action = option._replace(outputs=num_actions)
    if method.hierarchical:
        attended = Attended[config.attended.upper()] if method.attention else Attended.NOTHING
        action = action._replace(reads_option=True, attended=attended, sees_line=config.sees_line)
    networks = {"option": option, "action": action}
    return {level: networks[level] for level in method.levels}


def method_shapes(method: Method, num_actions: int) -> Shapes:
    """Return the parameter shapes of the networks of the method's learned levels, their names behind `option.` etc."""
    networks = architectures(method, num_actions)
    return {f"{level}.{name}": shape for level, network in networks.items() for name, shape in network.shapes().items()}


def frozen_shapes(method: Method, num_actions: int) -> Shapes:
    """Return the parameter shapes of what the method does not learn: those of its FFV policy, behind `FROZEN`."""
    shapes = method_shapes(method.ffv, num_actions) if method.ffv else {}
    return {f"{FROZEN}{name}": shape for name, shape in shapes.items()}
