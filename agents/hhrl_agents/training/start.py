"""Where a training begins: from nothing, or from the parameters of an earlier one."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from torch import Tensor

from hhrl_agents.methods.method import Method
from hhrl_agents.networks.mlp import Shapes
from hhrl_envs.errors import InputError, require_value


@dataclass(frozen=True, eq=False)
class Start:
    """What stacked seeds begin with, and which of their levels go on learning.

    Attributes:
        parameters: for each seed the parameters that it takes over, name -> [1, in, out]; all others are drawn. Empty:
            every seed begins from nothing.
        fixed: levels, of those that the method learns, that stay as they are taken over.
        epsilon: share of random choices at the first step; it falls to the config's `final_epsilon`.
    """

    parameters: Sequence[Mapping[str, Tensor]] = ()
    fixed: tuple[str, ...] = ()
    epsilon: float = 1.0

    def __post_init__(self) -> None:
        """Reject an epsilon that is no share."""
        require_value(0 <= self.epsilon <= 1, "epsilon", repr(self.epsilon), "a number in [0, 1]")

    def require_fit(self, method: Method, shapes: Shapes, seeds: Sequence[int]) -> None:
        """Return nothing.

        Raises:
            InputError: if there are parameters for other than these seeds, some that the method's networks of these
                `shapes` do not have, or no level is left to learn.
        """
        if self.parameters and len(self.parameters) != len(seeds):
            raise InputError(
                f"a start for {len(self.parameters)} seeds does not fit {len(seeds)}; give one for each seed"
            )
        for name, value in (item for parameters in self.parameters for item in parameters.items()):
            wanted = (1, *shapes[name]) if name in shapes else None
            if tuple(value.shape) != wanted:
                raise InputError(
                    f"parameter {name} of shape {tuple(value.shape)} does not fit method {method.id!r}, which has "
                    f"{wanted or 'no such parameter'}; start from a run of the same method"
                )
        left = set(method.levels) - set(self.fixed)
        if not left or not set(self.fixed) <= set(method.levels):
            raise InputError(
                f"levels {', '.join(self.fixed)} cannot stay fixed in method {method.id!r}, which learns "
                f"{' and '.join(method.levels)}; leave one to learn"
            )


NOTHING = Start()
"""The ordinary start: every parameter is drawn, every level learns."""
