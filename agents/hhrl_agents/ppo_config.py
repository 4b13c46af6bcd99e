"""Every hyperparameter of Proximal Policy Optimization, as data."""

from dataclasses import dataclass
from math import isfinite
from typing import Literal

from hhrl_agents.network_config import NetworkConfig


@dataclass(frozen=True)
class PPOConfig(NetworkConfig):
    """Every hyperparameter of PPO (Schulman et al. 2017); one seed's counts, whatever is trained beside it.

    Attributes:
        n_envs: environments stepped together.
        rollout_steps: steps of each environment between two updates of the policy.
        epochs: passes over a rollout.
        batch_size: transitions for each gradient step; a whole number of them makes a rollout.
        learning_rate, final_learning_rate: Adam's, changed linearly over the training budget.
        max_gradient_norm: bound of the gradient.
        gamma: discount of one step.
        gae_lambda: decay of the generalised advantage estimate.
        clip: how far a probability's ratio to the old policy's is followed from 1.
        throttle_bias: what an action's logit is raised by at first for each m/s^2 of its target acceleration. Levels
            brake harder than they accelerate: who takes all alike at first stands far from the line, and stays there.
        entropy_coefficient: weight of the policy's entropy in the loss.
        value_coefficient: weight of the value function's squared error in the loss.
        reward_scale: what rewards are multiplied with before learning.
        timeout: "truncation" bootstraps through the time limit and leaves the timeout penalty out of the reward;
            "terminal" is the paper's literal reading.
        report_every: environment steps between two progress reports, which come after whole rollouts.
    """

    n_envs: int = 16
    rollout_steps: int = 128
    epochs: int = 10
    batch_size: int = 256
    learning_rate: float = 1e-3
    final_learning_rate: float = 1e-5
    max_gradient_norm: float = 0.5
    gamma: float = 0.99
    gae_lambda: float = 0.95
    clip: float = 0.2
    throttle_bias: float = 0.22
    entropy_coefficient: float = 0.0
    value_coefficient: float = 0.5
    reward_scale: float = 0.05
    timeout: Literal["truncation", "terminal"] = "truncation"
    report_every: int = 10_000

    def __post_init__(self) -> None:
        """Reject values without a meaning."""
        super().__post_init__()
        self._require("layer_norm", not self.layer_norm, "False, the networks are Stable-Baselines3's")
        self._require("memory", not self.memory, "(), the networks are Stable-Baselines3's")
        for name in ("n_envs", "rollout_steps", "epochs", "report_every"):
            self._require(name, getattr(self, name) >= 1, "a whole number, at least 1")
        for name in ("learning_rate", "final_learning_rate", "max_gradient_norm", "clip", "reward_scale"):
            self._require(name, getattr(self, name) > 0, "a number above 0")
        for name in ("gamma", "gae_lambda"):
            self._require(name, 0 <= getattr(self, name) <= 1, "a number in [0, 1]")
        for name in ("entropy_coefficient", "value_coefficient"):
            self._require(name, getattr(self, name) >= 0, "a number, at least 0")
        self._require("throttle_bias", isfinite(self.throttle_bias), "a finite number")
        rollout = self.n_envs * self.rollout_steps
        divides = self.batch_size >= 2 and rollout % self.batch_size == 0
        self._require("batch_size", divides, f"a divisor, at least 2, of n_envs * rollout_steps ({rollout})")
        self._require("timeout", self.timeout in {"truncation", "terminal"}, "truncation or terminal")
