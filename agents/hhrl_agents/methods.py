"""Learning methods as data: what distinguishes them, and every hyperparameter of their learner."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from types import MappingProxyType
from typing import Any, Literal

from hhrl_agents.double_dqn_config import DoubleDQNConfig
from hhrl_agents.ppo_config import PPOConfig
from hhrl_agents.pqn_config import PQNConfig
from hhrl_envs.errors import InputError, require_value

CONFIGS: Mapping[str, Any] = MappingProxyType({"double-dqn": DoubleDQNConfig, "pqn": PQNConfig, "ppo": PPOConfig})
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
        config: every hyperparameter; its class, one of `CONFIGS`, says which algorithm learns.
    """

    id: str
    hierarchical: bool = False
    hybrid_reward: bool = False
    replay: Literal["uniform", "prioritised", "hierarchical"] = "uniform"
    attention: bool = False
    config: Any = field(default_factory=DoubleDQNConfig)

    def __post_init__(self) -> None:
        """Reject switches that a flat method does not have, or another algorithm than Double DQN."""
        known = type(self.config) in CONFIGS.values()
        classes = ", ".join(config.__name__ for config in CONFIGS.values())
        require_value(known, f"config of method {self.id!r}", repr(self.config), f"one of: {classes}")
        if self.replay not in {"uniform", "prioritised", "hierarchical"}:
            allowed = "write uniform, prioritised or hierarchical"
            raise InputError(f"method {self.id!r} has replay {self.replay!r}; {allowed}")
        if self.hierarchical and self.algorithm != "double-dqn":
            raise InputError(
                f"method {self.id!r} is hierarchical; give it a DoubleDQNConfig: Double DQN learns hierarchies"
            )
        if not self.hierarchical and (self.hybrid_reward or self.replay == "hierarchical" or self.attention):
            raise InputError(f"method {self.id!r} is flat; write hierarchical=True to use a switch of the hierarchy")

    @property
    def algorithm(self) -> str:
        """The name of the algorithm that learns, a key of `CONFIGS`."""
        return next(name for name, config in CONFIGS.items() if type(self.config) is config)

    @property
    def config_hash(self) -> str:
        """The SHA-256 of the method's data without its id: equal hashes learn the same from the same seeds."""
        return hashlib.sha256(json.dumps(self.data(), sort_keys=True, allow_nan=False).encode()).hexdigest()

    def data(self) -> dict[str, Any]:
        """Return the method without its id as JSON data."""
        data = asdict(self)
        del data["id"]
        data["algorithm"] = self.algorithm
        data["config"] = {name: list(v) if isinstance(v, tuple) else v for name, v in data["config"].items()}
        return data

    @classmethod
    def from_data(cls, method_id: str, data: Mapping[str, Any]) -> "Method":
        """Return the method of this id and `data`, the inverse of `data`.

        Raises:
            InputError: if an entry is missing or not known, or a value not allowed.
        """
        try:
            config = {name: tuple(v) if isinstance(v, list) else v for name, v in data["config"].items()}
            others = {name: value for name, value in data.items() if name != "algorithm"}
            method = cls(method_id, **{**others, "config": CONFIGS[data["algorithm"]](**config)})
            _require_entries(method.data(), data)
            _require_entries(method.data()["config"], config)
        except (KeyError, TypeError) as error:
            raise InputError(f"the config of method {method_id!r} is not one of this version: {error}") from error
        return method


def _require_entries(expected: Mapping[str, Any], given: Mapping[str, Any]) -> None:
    missing = ", ".join(sorted(expected.keys() - given.keys()))
    if missing:
        raise KeyError(f"missing {missing}")
