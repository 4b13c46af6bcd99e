"""The hyperparameters of every algorithm, as data; a class says which learner reads it, and imports nothing of it.

To add an algorithm, add its class here, in ``CONFIGS`` too, its learner in ``hhrl_agents.algorithms`` and a method that
uses it in ``hhrl_agents.methods.registry``.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from sys import float_info
from types import MappingProxyType
from typing import ClassVar, Literal

from hhrl_envs.observation import SIZE
from hhrl_envs.scenario.validation import Rule, agree, check, is_integer, is_number, one_of

SHARE = Rule(lambda value: is_number(value, 0.0, 1.0), "a number in [0, 1]")
"""The rule of a share."""

_LARGEST = float_info.max
_COUNT = Rule(lambda value: is_integer(value) and value >= 1, "a whole number, at least 1")
_POSITIVE = Rule(lambda value: is_number(value, 0.0, _LARGEST) and value > 0.0, "a number above 0")
_NOT_NEGATIVE = Rule(lambda value: is_number(value, 0.0, _LARGEST), "a number, at least 0")
_FINITE = Rule(lambda value: is_number(value, -_LARGEST, _LARGEST), "a finite number")
_SHARE_BELOW_1 = Rule(lambda value: SHARE.holds(value) and value < 1.0, "a number in [0, 1)")
_SHARE_ABOVE_0 = Rule(lambda value: SHARE.holds(value) and value > 0.0, "a number in (0, 1]")
_WIDTHS = Rule(lambda value: len(value) > 0 and all(map(_COUNT.holds, value)), "one or more positive layer widths")
_RATES = Rule(lambda value: all(_SHARE_BELOW_1.holds(rate) and rate > 0.0 for rate in value), "rates in (0, 1)")


@dataclass(frozen=True)
class LearnerConfig:
    """The hyperparameters of every learner; counts are those of one seed, whatever is stacked beside it.

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
        learning_rate, final_learning_rate: Adam's, changed linearly over the training budget.
        max_gradient_norm: bound of each network's gradient, for each seed by itself.

    A class of its own for each algorithm says, for all of its methods:

    Attributes:
        algorithm: the algorithm's name.
        learner: where its learner is, "module:class"; see `hhrl_agents.training.learner.make_learner`.
        extra: a module that the learner needs and the optional dependency that brings it, if one does.
        has_options: whether it can learn the levels of a hierarchy.
        has_replay: whether it learns from a replay buffer, so that there is a way to sample it.
    """

    algorithm: ClassVar[str]
    learner: ClassVar[str]
    extra: ClassVar[tuple[str, str] | None] = None
    has_options: ClassVar[bool] = False
    has_replay: ClassVar[bool] = False

    hidden: tuple[int, ...] = (64, 64)
    layer_norm: bool = False
    memory: tuple[float, ...] = ()
    n_envs: int = 32
    gamma: float = 0.99
    reward_scale: float = 0.05
    jerk_weight: float = 1.0
    timeout: Literal["truncation", "terminal"] = "truncation"
    report_every: int = 10_000
    learning_rate: float = 1e-3
    final_learning_rate: float = 5e-5
    max_gradient_norm: float = 5.0

    def __post_init__(self) -> None:
        """Refuse values without a meaning."""
        check(self, "", hidden=_WIDTHS, memory=_RATES, timeout=one_of("truncation", "terminal"))
        check(self, "", n_envs=_COUNT, report_every=_COUNT, gamma=SHARE, jerk_weight=SHARE, reward_scale=_POSITIVE)
        check(self, "", learning_rate=_POSITIVE, final_learning_rate=_POSITIVE, max_gradient_norm=_POSITIVE)

    @property
    def features(self) -> int:
        """How many numbers the networks read of a state: its elements, and as many for each trace of them."""
        return SIZE * (1 + len(self.memory))

    def learning_rate_at(self, share: float) -> float:
        """Return the learning rate after this share of the training budget."""
        return linear_schedule(self.learning_rate, self.final_learning_rate, share)


@dataclass(frozen=True)
class EpsilonGreedyConfig(LearnerConfig):
    """The hyperparameters of learners that explore by random choices.

    Attributes:
        exploration_share: share of the budget over which epsilon falls from 1 to `final_epsilon`.
        final_epsilon: share of steps with a random choice after that, at every level that is learned.
        exploration_hold: steps for which a random choice is held at most (1: plain epsilon-greedy).
    """

    exploration_share: float = 0.3
    final_epsilon: float = 0.02
    exploration_hold: int = 20

    def __post_init__(self) -> None:
        """Refuse values without a meaning."""
        super().__post_init__()
        check(self, "", exploration_share=_POSITIVE, final_epsilon=SHARE, exploration_hold=_COUNT)

    def epsilon_at(self, share: float, first: float = 1.0) -> float:
        """Return the share of random choices after this share of the training budget; it begins with `first`."""
        return linear_schedule(first, self.final_epsilon, share / self.exploration_share)


@dataclass(frozen=True)
class DoubleDQNConfig(EpsilonGreedyConfig):
    """The hyperparameters of Double DQN, beside those of every learner that explores.

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
        priority: p^a of the hierarchical prioritised replay. "clip" is max(|delta_a| - |delta_o|, 0) of scaled errors,
            "shift" the paper's literal |delta_a| - p^o minus its minimum over the mini-batch.
        priority_floor: what is added to every priority, in units of a level's typical error, so that none is forgotten.
        priority_exponent, importance_exponent: alpha and beta of Algorithm 3.
    """

    algorithm = "double-dqn"
    learner = "hhrl_agents.algorithms.double_dqn:DoubleDQNLearner"
    has_options = True
    has_replay = True

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
    priority: Literal["clip", "shift"] = "clip"
    priority_floor: float = 0.3
    priority_exponent: float = 0.6
    importance_exponent: float = 0.4

    def __post_init__(self) -> None:
        """Refuse values without a meaning."""
        super().__post_init__()
        check(self, "", steps_per_update=_COUNT, batch_size=_COUNT, n_steps=_COUNT, advantage_learning=_SHARE_BELOW_1)
        check(self, "", target_interval=_COUNT, target_rate=_SHARE_ABOVE_0)
        check(self, "", attended=one_of("state", "linear"), credit=one_of("equations", "algorithm-2"))
        check(self, "", priority=one_of("clip", "shift"), priority_floor=_POSITIVE)
        check(self, "", priority_exponent=SHARE, importance_exponent=SHARE)
        first = self.n_steps * self.n_envs
        enough = f"at least n_steps x n_envs ({first})"
        agree(self, self.warmup >= first, "warmup", write=enough, label="")
        kept = f"at least warmup ({self.warmup})"
        agree(self, self.replay_capacity >= self.warmup, "replay_capacity", write=kept, label="")
        plain = self.attended == "state" or not self.memory
        agree(self, plain, "attended", write="state, where there is memory: the linear layer sees none", label="")


@dataclass(frozen=True)
class PQNConfig(EpsilonGreedyConfig):
    """The hyperparameters of PQN (Gallici et al. 2024), beside those of every learner that explores.

    Attributes:
        rollout_steps: steps of each environment between two phases of learning.
        epochs: passes over a rollout.
        minibatches: gradient steps a pass; a divisor of the rollout's transitions.
        trace_decay: lambda of the returns Q(lambda); 0 looks one step ahead, 1 to the end of the rollout.
    """

    algorithm = "pqn"
    learner = "hhrl_agents.algorithms.pqn:PQNLearner"

    layer_norm: bool = True
    rollout_steps: int = 32
    epochs: int = 4
    minibatches: int = 16
    trace_decay: float = 0.65

    def __post_init__(self) -> None:
        """Refuse values without a meaning."""
        super().__post_init__()
        check(self, "", rollout_steps=_COUNT, epochs=_COUNT, minibatches=_COUNT, trace_decay=SHARE)
        divides = self.rollout_size % self.minibatches == 0
        divisor = f"a divisor of n_envs * rollout_steps ({self.rollout_size})"
        agree(self, divides, "minibatches", write=divisor, label="")

    @property
    def rollout_size(self) -> int:
        """Transitions of a rollout."""
        return self.n_envs * self.rollout_steps


@dataclass(frozen=True)
class PPOConfig(LearnerConfig):
    """The hyperparameters of PPO (Schulman et al. 2017), beside those of every learner.

    Attributes:
        rollout_steps: steps of each environment between two updates of the policy.
        epochs: passes over a rollout.
        batch_size: transitions for each gradient step; a whole number of them makes a rollout.
        gae_lambda: decay of the generalised advantage estimate.
        clip: how far a probability's ratio to the old policy's is followed from 1.
        throttle_bias: what an action's logit is raised by at first for each m/s^2 of its target acceleration. Levels
            brake harder than they accelerate: who takes all alike at first stands far from the line, and stays there.
        entropy_coefficient: weight of the policy's entropy in the loss.
        value_coefficient: weight of the value function's squared error in the loss.
    """

    algorithm = "ppo"
    learner = "hhrl_agents.algorithms.ppo:PPOLearner"
    extra = ("stable_baselines3", "sb3")

    n_envs: int = 16
    rollout_steps: int = 128
    epochs: int = 10
    batch_size: int = 256
    final_learning_rate: float = 1e-5
    max_gradient_norm: float = 0.5
    gae_lambda: float = 0.95
    clip: float = 0.2
    throttle_bias: float = 0.22
    entropy_coefficient: float = 0.0
    value_coefficient: float = 0.5

    def __post_init__(self) -> None:
        """Refuse values without a meaning."""
        super().__post_init__()
        check(self, "", rollout_steps=_COUNT, epochs=_COUNT, gae_lambda=SHARE, clip=_POSITIVE, throttle_bias=_FINITE)
        check(self, "", entropy_coefficient=_NOT_NEGATIVE, value_coefficient=_NOT_NEGATIVE)
        theirs = "the networks are Stable-Baselines3's"
        agree(self, not self.layer_norm, "layer_norm", write=f"False, {theirs}", label="")
        agree(self, not self.memory, "memory", write=f"(), {theirs}", label="")
        rollout = self.n_envs * self.rollout_steps
        divides = self.batch_size >= 2 and rollout % self.batch_size == 0
        divisor = f"a divisor, at least 2, of n_envs * rollout_steps ({rollout})"
        agree(self, divides, "batch_size", write=divisor, label="")


def linear_schedule(first: float, last: float, share: float) -> float:
    """Return the value at `share` of the way from `first` to `last`; `last` beyond it."""
    return first + (last - first) * min(share, 1.0)


CONFIGS: Mapping[str, type[LearnerConfig]] = MappingProxyType(
    {config.algorithm: config for config in (DoubleDQNConfig, PQNConfig, PPOConfig)}
)
"""The class of the hyperparameters of each algorithm, by the algorithm's name."""
