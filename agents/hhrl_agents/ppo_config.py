"""Every hyperparameter of Proximal Policy Optimization, as data."""

from dataclasses import dataclass
from math import isfinite

from hhrl_agents.learner_config import LearnerConfig


@dataclass(frozen=True)
class PPOConfig(LearnerConfig):
    """The hyperparameters of PPO (Schulman et al. 2017), beside those of every learner.

    Attributes:
        rollout_steps: steps of each environment between two updates of the policy.
        epochs: passes over a rollout.
        batch_size: transitions for each gradient step; a whole number of them makes a rollout.
        learning_rate, final_learning_rate: Adam's, changed linearly over the training budget.
        max_gradient_norm: bound of the gradient.
        gae_lambda: decay of the generalised advantage estimate.
        clip: how far a probability's ratio to the old policy's is followed from 1.
        throttle_bias: what an action's logit is raised by at first for each m/s^2 of its target acceleration. Levels
            brake harder than they accelerate: who takes all alike at first stands far from the line, and stays there.
        entropy_coefficient: weight of the policy's entropy in the loss.
        value_coefficient: weight of the value function's squared error in the loss.
    """

    n_envs: int = 16
    rollout_steps: int = 128
    epochs: int = 10
    batch_size: int = 256
    learning_rate: float = 1e-3
    final_learning_rate: float = 1e-5
    max_gradient_norm: float = 0.5
    gae_lambda: float = 0.95
    clip: float = 0.2
    throttle_bias: float = 0.22
    entropy_coefficient: float = 0.0
    value_coefficient: float = 0.5

    def __post_init__(self) -> None:
        """Reject values without a meaning."""
        super().__post_init__()
        self._require("layer_norm", not self.layer_norm, "False, the networks are Stable-Baselines3's")
        self._require("memory", not self.memory, "(), the networks are Stable-Baselines3's")
        self._require_counts("rollout_steps", "epochs")
        self._require_positive("learning_rate", "final_learning_rate", "max_gradient_norm", "clip")
        self._require_shares("gae_lambda")
        for name in ("entropy_coefficient", "value_coefficient"):
            self._require(name, getattr(self, name) >= 0, "a number, at least 0")
        self._require("throttle_bias", isfinite(self.throttle_bias), "a finite number")
        rollout = self.n_envs * self.rollout_steps
        divides = self.batch_size >= 2 and rollout % self.batch_size == 0
        self._require("batch_size", divides, f"a divisor, at least 2, of n_envs * rollout_steps ({rollout})")
