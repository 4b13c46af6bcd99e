"""Every hyperparameter of the parallelised Q-network, as data."""

from dataclasses import dataclass

from hhrl_agents.learner_config import LearnerConfig


@dataclass(frozen=True)
class PQNConfig(LearnerConfig):
    """The hyperparameters of PQN (Gallici et al. 2024), beside those of every learner.

    Attributes:
        rollout_steps: steps of each environment between two phases of learning.
        epochs: passes over a rollout.
        minibatches: gradient steps a pass; a divisor of the rollout's transitions.
        trace_decay: lambda of the returns Q(lambda); 0 looks one step ahead, 1 to the end of the rollout.
        learning_rate, final_learning_rate: Adam's, changed linearly over the training budget.
        max_gradient_norm: bound of the gradient, for each seed by itself.
        exploration_share: share of the budget over which epsilon falls from 1 to `final_epsilon`.
        final_epsilon: share of steps with a random action after that.
        exploration_hold: steps for which a random action is held at most (1: plain epsilon-greedy).
    """

    layer_norm: bool = True
    rollout_steps: int = 32
    epochs: int = 4
    minibatches: int = 16
    trace_decay: float = 0.65
    learning_rate: float = 1e-3
    final_learning_rate: float = 5e-5
    max_gradient_norm: float = 5.0
    exploration_share: float = 0.3
    final_epsilon: float = 0.02
    exploration_hold: int = 20

    def __post_init__(self) -> None:
        """Reject values without a meaning."""
        super().__post_init__()
        self._require_counts("rollout_steps", "epochs", "minibatches", "exploration_hold")
        self._require_positive("learning_rate", "final_learning_rate", "max_gradient_norm", "exploration_share")
        self._require_shares("trace_decay", "final_epsilon")
        divides = self.rollout_size % self.minibatches == 0
        self._require("minibatches", divides, f"a divisor of n_envs * rollout_steps ({self.rollout_size})")

    @property
    def rollout_size(self) -> int:
        """Transitions of a rollout."""
        return self.n_envs * self.rollout_steps
