"""Every hyperparameter of the Double DQN learners, flat and hierarchical, as data."""

from dataclasses import dataclass
from typing import Literal

from hhrl_agents.learner_config import LearnerConfig

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
