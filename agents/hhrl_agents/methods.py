"""Learning methods as data: what distinguishes them, and every hyperparameter of their learner."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

from hhrl_agents.rules import PAPER_RULES
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
        sees_line: without it d_d, d_dc and d_dc/d_ds are zero to the action network, so that what it learns where there
            is no stop-line holds where there is one.
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
    sees_line: bool = True
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


@dataclass(frozen=True)
class Method:
    """A learning method: an option level and an action level, each learned or given, with the paper's three switches.

    Attributes:
        id: the name that the command line and the leaderboard use.
        option: the option level: "none" of a flat method, "learned", or given by the rule of this id.
        ffv: the method whose trained policy, frozen, is the action level under FFV, the analytic controller being it
            under SSL; None: the action level is learned.
        hybrid_reward: r^option and r^action at their levels instead of r^task at both.
        replay: how mini-batches are drawn: "uniform", "prioritised" by all levels' errors together, or "hierarchical".
        attention: the attention I(s, o) before the action network.
        config: every hyperparameter.
        summary: what sets the method apart, in a line.
    """

    id: str
    option: str = "none"
    ffv: "Method | None" = None
    hybrid_reward: bool = False
    replay: Literal["uniform", "prioritised", "hierarchical"] = "uniform"
    attention: bool = False
    config: LearnerConfig = field(default_factory=LearnerConfig)
    summary: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        """Reject levels that do not go together, and switches of a level that is not there to learn."""
        options, replays = ("none", "learned", *PAPER_RULES), ("uniform", "prioritised", "hierarchical")
        self._require("option", self.option in options, "one of: " + ", ".join(options))
        self._require("replay", self.replay in replays, "one of: " + ", ".join(replays))
        flat_has_none = self.hierarchical or not (self.hybrid_reward or self.attention or self.ffv)
        self._require("option", flat_has_none, "'learned' or a rule's id to use ffv, hybrid_reward or attention")
        self._require("option", bool(self.levels), "'learned', as ffv gives the action level")
        self._require("attention", self.ffv is None or not self.attention, "False, as ffv gives the action level")
        both = self.replay != "hierarchical" or len(self.levels) == 2
        self._require("replay", both, "uniform or prioritised, as hierarchical needs option 'learned' and no ffv")
        follows = self.ffv is None or (self.ffv.hierarchical and self.ffv.ffv is None)
        self._require("ffv", follows, "a method with options whose action level is learned")

    def _require(self, name: str, holds: bool, allowed: str) -> None:
        value = getattr(self, name)
        said = repr(value.id) if isinstance(value, Method) else repr(value)
        require_value(holds, f"{name} of method {self.id!r}", said, allowed)

    @property
    def hierarchical(self) -> bool:
        """Whether there is an option level, learned or given."""
        return self.option != "none"

    @property
    def levels(self) -> tuple[str, ...]:
        """The levels that are learned, of "option" and "action", in this order."""
        learned = {"option": self.option == "learned", "action": self.ffv is None}
        return tuple(level for level, is_learned in learned.items() if is_learned)

    @property
    def config_hash(self) -> str:
        """The SHA-256 of the method's data without its id: equal hashes learn the same from the same seeds."""
        return hashlib.sha256(json.dumps(self.data(), sort_keys=True, allow_nan=False).encode()).hexdigest()

    def data(self) -> dict[str, Any]:
        """Return the method without its id and summary as JSON data; that of `ffv` holds its id."""
        data = asdict(self)
        del data["id"], data["summary"]
        data["config"]["hidden"] = list(self.config.hidden)
        if self.ffv:
            data["ffv"] = {"id": self.ffv.id, **self.ffv.data()}
        return data

    @classmethod
    def from_data(cls, method_id: str, data: Mapping[str, Any]) -> "Method":
        """Return the method of this id and `data`, the inverse of `data`.

        Raises:
            InputError: if an entry is missing or not known, or a value not allowed.
        """
        try:
            config = {**data["config"], "hidden": tuple(data["config"]["hidden"])}
            ffv = data["ffv"] and cls.from_data(data["ffv"]["id"], _without_id(data["ffv"]))
            method = cls(method_id, **{**data, "ffv": ffv, "config": LearnerConfig(**config)})
        except (KeyError, TypeError) as error:
            raise InputError(f"the config of method {method_id!r} is not one of this version: {error}") from error
        return method


def _without_id(data: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in data.items() if name != "id"}
