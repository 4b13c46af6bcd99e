"""What the learners of every algorithm have in common, as data."""

from dataclasses import dataclass
from math import isfinite
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


_READINGS = {
    "priority": ("clip", "shift"),
    "attended": ("state", "linear"),
    "credit": ("equations", "algorithm-2"),
}


@dataclass(frozen=True)
class DoubleDQNConfig(LearnerConfig):
    """The hyperparameters of Double DQN, beside those of every learner.

    Attributes:
        steps_per_update: environment steps for each gradient step.
        batch_size: transitions for each level's gradient step.
        replay_capacity: transitions kept.
        warmup: environment steps of random actions before the first gradient step.
        target_interval: gradient steps between two moves of the target networks.
        target_rate: share by which a move brings their parameters towards the online ones: 1 copies them (with
            `target_interval` = 1 at every call, the paper's literal reading), little at every step is Polyak averaging.
        attended: what the attention multiplies: the "state" (the text), or the "linear" layer of it (Figure 2).
        sees_line: whether the action level's network reads the state elements of the stop-line; they are 0 without.
        credit: whose fault the failure of a sub-goal is, by the reward "equations" or by "algorithm-2".
        n_steps: steps of reward in a target before it bootstraps.
        advantage_learning: alpha of advantage learning (Bellemare et al., 2016), which takes the share alpha of
            max Q'(s) - Q'(s, a) off every target, Q' the target network: choices that a step of 0.1 s hardly tells
            apart differ more in value, and keep their order.
        learning_rate, final_learning_rate: Adam's, changed linearly over the training budget.
        max_gradient_norm: bound of each network's gradient, for each seed by itself.
        exploration_share: share of the budget over which epsilon falls from 1 to `final_epsilon`.
        final_epsilon: share of steps with a random option, and of steps with a random action, after that.
        exploration_hold: steps for which a random choice is held at most (1: plain epsilon-greedy).
        priority: p^a of the hierarchical prioritised replay. "clip" is max(|delta_a| - |delta_o|, 0) of scaled errors,
            "shift" the paper's literal |delta_a| - |delta_o| minus its minimum over the batch.
        priority_floor: what is added to every priority, in units of a level's typical error, so that none is forgotten.
        priority_exponent, importance_exponent: alpha and beta of Algorithm 3.
    """

    steps_per_update: int = 4
    batch_size: int = 64
    replay_capacity: int = 100_000
    warmup: int = 2_000
    target_interval: int = 100
    target_rate: float = 1.0
    attended: Literal["state", "linear"] = "state"
    sees_line: bool = True
    credit: Literal["equations", "algorithm-2"] = "equations"
    n_steps: int = 1
    advantage_learning: float = 0.0
    learning_rate: float = 1e-3
    final_learning_rate: float = 5e-5
    max_gradient_norm: float = 5.0
    exploration_share: float = 0.3
    final_epsilon: float = 0.02
    exploration_hold: int = 20
    priority: Literal["clip", "shift"] = "clip"
    priority_floor: float = 0.3
    priority_exponent: float = 0.6
    importance_exponent: float = 0.4

    def __post_init__(self) -> None:
        """Reject values without a meaning."""
        super().__post_init__()
        self._require_counts("steps_per_update", "batch_size", "target_interval", "n_steps", "exploration_hold")
        self._require_positive("learning_rate", "final_learning_rate", "max_gradient_norm", "exploration_share")
        self._require_positive("priority_floor")
        self._require_shares("final_epsilon", "priority_exponent", "importance_exponent")
        first = self.n_steps * self.n_envs
        self._require("warmup", self.warmup >= first, f"at least n_steps x n_envs ({first})")
        self._require("replay_capacity", self.replay_capacity >= self.warmup, f"at least warmup ({self.warmup})")
        self._require("advantage_learning", 0 <= self.advantage_learning < 1, "a number in [0, 1)")
        plain = self.attended == "state" or not self.memory
        self._require("attended", plain, "state, where there is memory: the linear layer sees none")
        self._require("target_rate", 0 < self.target_rate <= 1, "a number in (0, 1]")
        for name, readings in _READINGS.items():
            self._require(name, getattr(self, name) in readings, " or ".join(readings))


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
