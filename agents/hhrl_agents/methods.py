"""Learning methods as data: what distinguishes them, and every hyperparameter of their learner."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from types import MappingProxyType
from typing import Any, Literal

from hhrl_agents.pqn_config import PQNConfig
from hhrl_envs.errors import InputError, require_value

_READINGS = {
    "timeout": ("truncation", "terminal"),
    "priority": ("clip", "shift"),
    "attended": ("state", "linear"),
    "credit": ("equations", "algorithm-2"),
}


@dataclass(frozen=True)
class LearnerConfig:
    """Every hyperparameter of a learner; one seed's counts, whatever is stacked beside it.

    Attributes:
        hidden: units of the hidden layers of every network.
        n_envs: environments stepped together.
        steps_per_update: environment steps for each gradient step.
        batch_size: transitions for each level's gradient step.
        replay_capacity: transitions kept.
        warmup: environment steps of random actions before the first gradient step.
        target_interval: gradient steps between two moves of the target networks.
        target_rate: share by which a move brings their parameters towards the online ones: 1 copies them (with
            `target_interval` = 1 at every call, the paper's literal reading), little at every step is Polyak averaging.
        layer_norm: normalise what enters every ReLU.
        attended: what the attention multiplies: the "state" (the text), or the "linear" layer of it (Figure 2).
        credit: whose fault the failure of a sub-goal is, by the reward "equations" or by "algorithm-2".
        n_steps: steps of reward in a target before it bootstraps.
        learning_rate, final_learning_rate: Adam's, changed linearly over the training budget.
        max_gradient_norm: bound of each network's gradient, for each seed by itself.
        gamma: discount of one step.
        reward_scale: what rewards are multiplied with before learning.
        exploration_share: share of the budget over which epsilon falls from 1 to `final_epsilon`.
        final_epsilon: share of steps with a random option, and of steps with a random action, after that.
        exploration_hold: steps for which a random choice is held at most (1: plain epsilon-greedy).
        timeout: "truncation" bootstraps through the time limit and leaves the timeout penalty out of the target;
            "terminal" is the paper's literal reading.
        priority: p^a of the hierarchical prioritised replay. "clip" is max(|delta_a| - |delta_o|, 0) of scaled errors,
            "shift" the paper's literal |delta_a| - |delta_o| minus its minimum over the batch.
        priority_floor: what is added to every priority, in units of a level's typical error, so that none is forgotten.
        priority_exponent, importance_exponent: alpha and beta of Algorithm 3.
        report_every: environment steps between two progress reports.
    """

    hidden: tuple[int, ...] = (64, 64)
    n_envs: int = 32
    steps_per_update: int = 4
    batch_size: int = 64
    replay_capacity: int = 100_000
    warmup: int = 2_000
    target_interval: int = 100
    target_rate: float = 1.0
    layer_norm: bool = False
    attended: Literal["state", "linear"] = "state"
    credit: Literal["equations", "algorithm-2"] = "equations"
    n_steps: int = 1
    learning_rate: float = 1e-3
    final_learning_rate: float = 5e-5
    max_gradient_norm: float = 5.0
    gamma: float = 0.99
    reward_scale: float = 0.05
    exploration_share: float = 0.3
    final_epsilon: float = 0.02
    exploration_hold: int = 20
    timeout: Literal["truncation", "terminal"] = "truncation"
    priority: Literal["clip", "shift"] = "clip"
    priority_floor: float = 0.3
    priority_exponent: float = 0.6
    importance_exponent: float = 0.4
    report_every: int = 10_000

    def __post_init__(self) -> None:
        """Reject values without a meaning."""
        counts = (
            "n_envs",
            "steps_per_update",
            "batch_size",
            "target_interval",
            "exploration_hold",
            "report_every",
            "n_steps",
        )
        for name in counts:
            self._require(name, getattr(self, name) >= 1, "a whole number, at least 1")
        positive = ("learning_rate", "final_learning_rate", "max_gradient_norm", "reward_scale", "priority_floor")
        for name in (*positive, "exploration_share"):
            self._require(name, getattr(self, name) > 0, "a number above 0")
        for name in ("gamma", "final_epsilon", "priority_exponent", "importance_exponent"):
            self._require(name, 0 <= getattr(self, name) <= 1, "a number in [0, 1]")
        self._require("hidden", len(self.hidden) > 0 and min(self.hidden) > 0, "one or more positive layer widths")
        self._require("warmup", self.warmup >= self.n_envs, f"at least n_envs ({self.n_envs})")
        self._require("replay_capacity", self.replay_capacity >= self.warmup, f"at least warmup ({self.warmup})")
        self._require("target_rate", 0 < self.target_rate <= 1, "a number in (0, 1]")
        for name, readings in _READINGS.items():
            self._require(name, getattr(self, name) in readings, " or ".join(readings))

    def _require(self, name: str, holds: bool, allowed: str) -> None:
        require_value(holds, name, repr(getattr(self, name)), allowed)


CONFIGS: Mapping[str, type] = MappingProxyType({"double-dqn": LearnerConfig, "pqn": PQNConfig})
"""The class of each algorithm's hyperparameters."""


@dataclass(frozen=True)
class Method:
    """A learning method: a flat algorithm, or the hierarchical Double DQN with the paper's three switches.

    Attributes:
        id: the name that the command line and the leaderboard use.
        hierarchical: an option level over the action level; the switches below need it.
        hybrid_reward: r^option and r^action at their levels instead of r^task at both.
        replay: how mini-batches are drawn: "uniform", "prioritised" by all levels' errors together, or "hierarchical".
        attention: the attention I(s, o) before the action network.
        algorithm: what learns; all but Double DQN are flat.
        config: every hyperparameter, of the class `CONFIGS[algorithm]`.
    """

    id: str
    hierarchical: bool = False
    hybrid_reward: bool = False
    replay: Literal["uniform", "prioritised", "hierarchical"] = "uniform"
    attention: bool = False
    algorithm: Literal["double-dqn", "pqn"] = "double-dqn"
    config: Any = field(default_factory=LearnerConfig)

    def __post_init__(self) -> None:
        """Reject what the algorithm does not have, and switches that a flat method does not have."""
        require_value(self.algorithm in CONFIGS, "algorithm", repr(self.algorithm), f"one of: {', '.join(CONFIGS)}")
        config = CONFIGS[self.algorithm]
        require_value(type(self.config) is config, "config", repr(self.config), f"{config.__name__}(...)")
        if self.hierarchical and self.algorithm != "double-dqn":
            raise InputError(f"method {self.id!r} is hierarchical; write algorithm='double-dqn' to learn a hierarchy")
        if self.replay not in {"uniform", "prioritised", "hierarchical"}:
            raise InputError(
                f"method {self.id!r} has replay {self.replay!r}; write uniform, prioritised or hierarchical"
            )
        if not self.hierarchical and (self.hybrid_reward or self.replay == "hierarchical" or self.attention):
            raise InputError(f"method {self.id!r} is flat; write hierarchical=True to use a switch of the hierarchy")

    @property
    def config_hash(self) -> str:
        """The SHA-256 of the method's data without its id: equal hashes learn the same from the same seeds."""
        return hashlib.sha256(json.dumps(self.data(), sort_keys=True, allow_nan=False).encode()).hexdigest()

    def data(self) -> dict[str, Any]:
        """Return the method without its id as JSON data; Double DQN, the first algorithm, goes without saying."""
        data = asdict(self)
        del data["id"]
        if self.algorithm == "double-dqn":
            del data["algorithm"]
        data["config"]["hidden"] = list(self.config.hidden)
        return data

    @classmethod
    def from_data(cls, method_id: str, data: Mapping[str, Any]) -> "Method":
        """Return the method of this id and `data`, the inverse of `data`.

        Raises:
            InputError: if an entry is missing or not known, or a value not allowed.
        """
        try:
            config = {**data["config"], "hidden": tuple(data["config"]["hidden"])}
            kind = CONFIGS[data.get("algorithm", "double-dqn")]
            method = cls(method_id, **{**data, "config": kind(**config)})
        except (KeyError, TypeError) as error:
            raise InputError(f"the config of method {method_id!r} is not one of this version: {error}") from error
        return method
