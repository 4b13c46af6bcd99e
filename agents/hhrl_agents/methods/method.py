"""Learning methods as data: what distinguishes them, and every hyperparameter of their learner."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

from hhrl_agents.agent import LEVELS
from hhrl_agents.methods.configs import CONFIGS, DoubleDQNConfig
from hhrl_agents.rules import paper_rules
from hhrl_envs.errors import InputError
from hhrl_envs.scenario.validation import Rule, agree, check, one_of

_OPTION = one_of("none", "learned", *paper_rules.RULES)
_REPLAY = one_of("uniform", "prioritised", "hierarchical")
_CONFIG = Rule(
    lambda value: type(value) in CONFIGS.values(), "one of: " + ", ".join(kind.__name__ for kind in CONFIGS.values())
)
_SWITCHING = " or ".join(f"a {kind.__name__}" for kind in CONFIGS.values() if kind.has_options and kind.has_replay)


@dataclass(frozen=True)
class Method:
    """A learning method: an option level and an action level, each learned or given, with the paper's three switches.

    Attributes:
        id: the name that the command line and the leaderboard use.
        option: the option level: "none" of a flat method, "learned", or given by the rule of this id.
        ffv: the method whose trained policy, frozen, is the action level under FFV, the analytic controllers being it
            under every other sub-goal; None: the action level is learned.
        hybrid_reward: r^option and r^action at their levels instead of r^task at both.
        replay: how mini-batches are drawn: "uniform", "prioritised" by all levels' errors together, or "hierarchical".
        attention: the attention I(s, o) before the action network.
        config: every hyperparameter; its class, one of `CONFIGS`, says which algorithm learns.
        summary: what sets the method apart, in a line.
    """

    id: str
    option: str = "none"
    ffv: "Method | None" = None
    hybrid_reward: bool = False
    replay: Literal["uniform", "prioritised", "hierarchical"] = "uniform"
    attention: bool = False
    config: Any = field(default_factory=DoubleDQNConfig)
    summary: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        """Refuse levels that do not go together, and switches of a level that is not there to learn."""
        check(self, self._label, config=_CONFIG, option=_OPTION, replay=_REPLAY)
        able = (self.config.has_options or not self.hierarchical) and (
            self.config.has_replay or self.replay == "uniform"
        )
        self._agree(able, "config", f"{_SWITCHING} to have options, or replay to choose from")
        flat_has_none = self.hierarchical or not (self.hybrid_reward or self.attention or self.ffv)
        self._agree(flat_has_none, "option", "'learned' or a rule's id to use ffv, hybrid_reward or attention")
        self._agree(bool(self.levels), "option", "'learned', as ffv gives the action level")
        self._agree(self.ffv is None or not self.attention, "attention", "False, as ffv gives the action level")
        both = self.replay != "hierarchical" or len(self.levels) == len(LEVELS)
        self._agree(both, "replay", "uniform or prioritised, as hierarchical needs option 'learned' and no ffv")
        follows = self.ffv is None or (self.ffv.hierarchical and self.ffv.ffv is None and not self.ffv.config.memory)
        self._agree(follows, "ffv", "a method with options whose action level is learned, without memory")

    @property
    def _label(self) -> str:
        return f"{{}} of method {self.id!r}"

    def _agree(self, holds: bool, name: str, write: str) -> None:
        agree(self, holds, name, write=write, label=self._label)

    @property
    def algorithm(self) -> str:
        """The name of the algorithm that learns, a key of `CONFIGS`."""
        name: str = self.config.algorithm
        return name

    @property
    def hierarchical(self) -> bool:
        """Whether there is an option level, learned or given."""
        return self.option != "none"

    @property
    def levels(self) -> tuple[str, ...]:
        """The levels that are learned, of `LEVELS`, in this order."""
        learned = {"option": self.option == "learned", "action": self.ffv is None}
        return tuple(level for level in LEVELS if learned[level])

    @property
    def config_hash(self) -> str:
        """The SHA-256 of the method's data without its id: equal hashes learn the same from the same seeds."""
        return hashlib.sha256(json.dumps(self.data(), sort_keys=True, allow_nan=False).encode()).hexdigest()

    def data(self) -> dict[str, Any]:
        """Return the method without its id and summary as JSON data; that of `ffv` holds its id."""
        data = asdict(self)
        del data["id"], data["summary"]
        data["algorithm"] = self.algorithm
        data["config"] = {name: list(v) if isinstance(v, tuple) else v for name, v in data["config"].items()}
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
            config: dict[str, Any] = {
                name: tuple(v) if isinstance(v, list) else v for name, v in data["config"].items()
            }
            ffv = data["ffv"] and cls.from_data(data["ffv"]["id"], _without(data["ffv"], "id"))
            made = {"ffv": ffv, "config": CONFIGS[data["algorithm"]](**config)}
            method = cls(method_id, **{**_without(data, "algorithm"), **made})
            _require_entries(method.data(), data)
            _require_entries(method.data()["config"], config)
        except (AttributeError, KeyError, TypeError) as error:
            raise InputError(f"the config of method {method_id!r} is not one of this version: {error}") from error
        return method


def _without(data: Mapping[str, Any], key: str) -> dict[str, Any]:
    return {name: value for name, value in data.items() if name != key}


def _require_entries(expected: Mapping[str, Any], given: Mapping[str, Any]) -> None:
    missing = ", ".join(sorted(expected.keys() - given.keys()))
    if missing:
        raise KeyError(f"missing {missing}")
