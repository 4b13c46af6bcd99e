"""What the networks of every algorithm have in common, as data."""

from dataclasses import dataclass

from hhrl_envs.errors import require_value
from hhrl_envs.observation import SIZE


@dataclass(frozen=True)
class NetworkConfig:
    """The hyperparameters that a trained policy needs to act.

    Attributes:
        hidden: units of the hidden layers of every network.
        layer_norm: normalise what enters every ReLU.
        memory: rates of the running averages of the observations that networks read beside the observation itself.
    """

    hidden: tuple[int, ...] = (64, 64)
    layer_norm: bool = False
    memory: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        """Reject values without a meaning."""
        self._require("hidden", len(self.hidden) > 0 and min(self.hidden) > 0, "one or more positive layer widths")
        self._require("memory", all(0 < rate < 1 for rate in self.memory), "rates in (0, 1)")

    @property
    def features(self) -> int:
        """How many numbers the networks read of a state: the 11 elements, and as many for each trace of them."""
        return SIZE * (1 + len(self.memory))

    def _require(self, name: str, holds: bool, allowed: str) -> None:
        require_value(holds, name, repr(getattr(self, name)), allowed)
