"""Every hyperparameter of the parallelised Q-network, as data."""

from dataclasses import dataclass
from typing import Literal

from hhrl_envs.errors import require_value


@dataclass(frozen=True)
class PQNConfig:
    """Every hyperparameter of PQN (Gallici et al. 2024); one seed's counts, whatever is stacked beside it.

    Attributes:
        hidden: units of the hidden layers of the network.
        layer_norm: normalise what enters every ReLU; without it nothing keeps the values from growing without bound.
        n_envs: environments stepped together.
        rollout_steps: steps of each environment between two phases of learning.
        epochs: passes over a rollout.
        minibatches: gradient steps a pass; a divisor of the rollout's transitions.
        trace_decay: lambda of the returns Q(lambda); 0 looks one step ahead, 1 to the end of the rollout.
        learning_rate, final_learning_rate: Adam's, changed linearly over the training budget.
        max_gradient_norm: bound of the gradient, for each seed by itself.
        gamma: discount of one step.
        reward_scale: what rewards are multiplied with before learning.
        exploration_share: share of the budget over which epsilon falls from 1 to `final_epsilon`.
        final_epsilon: share of steps with a random action after that.
        exploration_hold: steps for which a random action is held at most (1: plain epsilon-greedy).
        timeout: "truncation" bootstraps through the time limit and leaves the timeout penalty out of the reward;
            "terminal" is the paper's literal reading.
        report_every: environment steps between two progress reports, which come after whole rollouts.
    """

    hidden: tuple[int, ...] = (64, 64)
    layer_norm: bool = True
    n_envs: int = 32
    rollout_steps: int = 32
    epochs: int = 4
    minibatches: int = 16
    trace_decay: float = 0.65
    learning_rate: float = 1e-3
    final_learning_rate: float = 5e-5
    max_gradient_norm: float = 5.0
    gamma: float = 0.99
    reward_scale: float = 0.05
    exploration_share: float = 0.3
    final_epsilon: float = 0.02
    exploration_hold: int = 20
    timeout: Literal["truncation", "terminal"] = "truncation"
    report_every: int = 10_000

    def __post_init__(self) -> None:
        """Reject values without a meaning."""
        for name in ("n_envs", "rollout_steps", "epochs", "minibatches", "exploration_hold", "report_every"):
            self._require(name, getattr(self, name) >= 1, "a whole number, at least 1")
        positive = ("learning_rate", "final_learning_rate", "max_gradient_norm", "reward_scale", "exploration_share")
        for name in positive:
            self._require(name, getattr(self, name) > 0, "a number above 0")
        for name in ("trace_decay", "gamma", "final_epsilon"):
            self._require(name, 0 <= getattr(self, name) <= 1, "a number in [0, 1]")
        self._require("hidden", len(self.hidden) > 0 and min(self.hidden) > 0, "one or more positive layer widths")
        divides = self.rollout_size % self.minibatches == 0
        self._require("minibatches", divides, f"a divisor of n_envs * rollout_steps ({self.rollout_size})")
        self._require("timeout", self.timeout in {"truncation", "terminal"}, "truncation or terminal")

    @property
    def rollout_size(self) -> int:
        """Transitions of a rollout."""
        return self.n_envs * self.rollout_steps

    def _require(self, name: str, holds: bool, allowed: str) -> None:
        require_value(holds, name, repr(getattr(self, name)), allowed)
