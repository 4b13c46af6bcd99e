"""What the learners of every algorithm have in common, as data."""

from dataclasses import dataclass
from typing import Literal

from hhrl_envs.errors import require_value
from hhrl_envs.observation import SIZE


@dataclass(frozen=True)
class LearnerConfig:
    """The hyperparameters of every learner; one seed's counts, whatever is stacked beside it.

    Attributes:
        hidden: units of the hidden layers of every network.
        layer_norm: normalise what enters every ReLU.
        memory: rates of the running averages of the observations that networks read beside the observation itself.
        n_envs: environments stepped together.
        gamma: discount of one step.
        reward_scale: what rewards are multiplied with before learning.
        jerk_weight: what the task's penalty for unsmoothness counts for in learning; 1 is the task's reward.
        timeout: "truncation" bootstraps through the time limit and leaves the timeout penalty out of the target;
            "terminal" is the paper's literal reading.
        report_every: environment steps between two progress reports.
    """

    hidden: tuple[int, ...] = (64, 64)
    layer_norm: bool = False
    memory: tuple[float, ...] = ()
    n_envs: int = 32
    gamma: float = 0.99
    reward_scale: float = 0.05
    jerk_weight: float = 1.0
    timeout: Literal["truncation", "terminal"] = "truncation"
    report_every: int = 10_000

    def __post_init__(self) -> None:
        """Reject values without a meaning."""
        self._require_counts("n_envs", "report_every")
        self._require_positive("reward_scale")
        self._require_shares("gamma", "jerk_weight")
        self._require("hidden", len(self.hidden) > 0 and min(self.hidden) > 0, "one or more positive layer widths")
        self._require("memory", all(0 < rate < 1 for rate in self.memory), "rates in (0, 1)")
        self._require("timeout", self.timeout in {"truncation", "terminal"}, "truncation or terminal")

    @property
    def features(self) -> int:
        """How many numbers the networks read of a state: the 11 elements, and as many for each trace of them."""
        return SIZE * (1 + len(self.memory))

    def _require_counts(self, *names: str) -> None:
        for name in names:
            self._require(name, getattr(self, name) >= 1, "a whole number, at least 1")

    def _require_positive(self, *names: str) -> None:
        for name in names:
            self._require(name, getattr(self, name) > 0, "a number above 0")

    def _require_shares(self, *names: str) -> None:
        for name in names:
            self._require(name, 0 <= getattr(self, name) <= 1, "a number in [0, 1]")

    def _require(self, name: str, holds: bool, allowed: str) -> None:
        require_value(holds, name, repr(getattr(self, name)), allowed)
